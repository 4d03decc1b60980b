// Points of scalar laws, each on one straight piece of its law's slope.
#pragma once

#include "solver/inequality/points.hpp"

namespace hvi::solver {

/// s + k (z - centre) on [low, high].
struct StraightPiece {
  double low = 0.0, high = 0.0, centre = 0.0, s = 0.0, k = 0.0;
  int component = 0;
};

class StraightPieces {
public:
  explicit StraightPieces(const ContactPoints& points) : points_(points) {}
  /// Are all laws made of straight pieces that do not move, each of one row?
  static bool possible(const ContactPoints& points);
  /// False where the law is so much stiffer than the body that z does not say what xi is.
  bool take(int p, int state);
  const StraightPiece& operator[](int p) const { return pieces_[p]; }
  const std::vector<int>& states() const { return states_; }

  /// The piece's state that a point is on at z when it left its own; -1: to a place where the
  /// piece cannot follow; -2: it did not leave.
  int next_state(int p, double z) const;
  static constexpr int unreachable = -1, stays = -2;
  void multipliers(const Vector& z, Vector& xi) const; ///< xi = the slopes at z
  void times_stiffness(const Vector& dz, Vector& out) const;
  void resize(std::size_t count) { pieces_.resize(count), states_.resize(count); }

private:
  const ContactPoints& points_;
  std::vector<StraightPiece> pieces_;
  std::vector<int> states_; ///< those that the pieces are of
};

} // namespace hvi::solver
