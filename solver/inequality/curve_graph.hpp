// A scalar law's graph over all arguments, as the equilibrium curve reads it.
#pragma once

#include "solver/inequality/prepared_law.hpp"

#include <vector>

namespace hvi::solver {

/// The graph of a scalar law over all arguments; a radial law with one row as an odd one.
class CurveGraph {
public:
  explicit CurveGraph(const PreparedLaw& law);

  int pieces() const { return static_cast<int>(breaks_.size()) + 1; }
  double low(int piece) const;
  double high(int piece) const;
  double at(int b) const { return breaks_[b]; }
  double below(int b) const { return left_[b]; } ///< the slope's limit from below break b
  double above(int b) const { return right_[b]; }
  bool straight(int piece) const { return straight_[piece]; }
  /// Slope and its derivative on a piece, which goes on along its tangents beyond its ends.
  void slope(int piece, double z, double& s, double& d) const;
  double potential(int piece, double z) const;
  /// A proved lower bound of the slope's derivative on a part of a piece; -infinity where there is
  /// none.
  double least_curvature(int piece, double low, double high) const;
  /// The engine's state (InequalityState) of a place: 2 i inside piece i, 2 i + 1 at break i.
  int engine_state(int place) const;
  int component(int place) const; ///< and the law's component there

private:
  int own_piece(int piece) const; ///< of the law's own graph
  const PreparedLaw* law_;
  bool odd_;
  std::vector<double> breaks_, left_, right_;
  std::vector<char> straight_;
};

} // namespace hvi::solver
