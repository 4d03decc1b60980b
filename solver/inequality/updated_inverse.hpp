// (S + H)^-1 for points on straight pieces, updated when a point goes to another piece:
//
//   (M + delta g g^T)^-1 = M^-1 - delta / (1 + delta g.v) v v^T,    v = M^-1 g.
#pragma once

#include "solver/inequality/stiffness.hpp"
#include "solver/inequality/straight_pieces.hpp"

#include <limits>
#include <utility>

namespace hvi::solver {

/// How an inverse came to be: its bits depend on the order of its updates.
struct InverseHistory {
  std::vector<int> first_states;            ///< of the points when it was made from a factor,
  std::vector<std::pair<int, int>> updates; ///< and (point, state) that it was updated with since
};

class UpdatedInverse {
public:
  UpdatedInverse(const ContactPoints& points, const StiffnessPattern& pattern,
                 const ReducedOperator& s);
  bool made() const { return made_; }
  const StraightPieces& pieces() const { return pieces_; }
  const InverseHistory& history() const { return history_; }

  /// Brings the inverse to the states of a warm start; makes it when it is worth that.
  bool bring(const std::vector<int>& states);
  /// Points that left their piece go to the one they are on at z. Their number; -1: to a place
  /// where this method does not reach.
  int follow(const Vector& z);
  void solve(const Vector& b, Vector& x) const;
  /// As another one was made. False: the laws are others.
  bool remake(const InverseHistory& history);
  void forget() { made_ = false; }

  /// Of its solves, relative in the largest norm, when last measured; infinite: not yet.
  double error = std::numeric_limits<double>::infinity();

private:
  bool make(const std::vector<int>& states);
  bool update(int p, int to_state);
  int most_moved() const { return 4 + points_.unknowns / 4; }

  const ContactPoints& points_;
  const StiffnessPattern& pattern_;
  const ReducedOperator& op_;
  bool made_ = false;
  DenseMatrix inverse_; ///< its lower triangle
  InverseHistory history_;
  StraightPieces pieces_;
};

} // namespace hvi::solver
