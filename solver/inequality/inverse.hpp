// What Newton's method keeps for laws of straight pieces: (S + H)^-1 itself (inverse.cpp).
#pragma once

#include "solver/linear/sparse.hpp"

#include <limits>
#include <utility>
#include <vector>

namespace hvi::solver {

/// A straight piece of a law's slope as one point stands on it: s + k (z - centre) on [low, high].
struct StraightPiece {
  double low = 0.0, high = 0.0, centre = 0.0, s = 0.0, k = 0.0;
  int component = 0;
};

struct KeptInverse {
  static constexpr int largest = 600; ///< unknowns: while it stays in the second cache
  bool possible = false;              ///< laws, operator and options are such that it may serve
  bool made = false;
  DenseMatrix inverse;                      ///< (S + H)^-1, its lower triangle
  std::vector<int> first_states;            ///< of the points when it was made from a factor,
  std::vector<std::pair<int, int>> updates; ///< and (point, state) that it was updated with since
  std::vector<int> states;                  ///< those it belongs to
  std::vector<StraightPiece> pieces;        ///< the same, by point
  /// Of its solves, relative in the largest norm, when last measured; infinite: not yet.
  double error = std::numeric_limits<double>::infinity();
  int waited = 0;          ///< solves that could have used it before it was made
  int rest = 0, pause = 4; ///< solves it is left alone after it failed, and after the next time
  Vector column, stiffness_dz, h_dc, product;
};

} // namespace hvi::solver
