// Small systems z = P(b + c g(z)), P the projection on a box: the states at one point in a step.
#pragma once

#include <functional>
#include <span>
#include <vector>

namespace hvi::solver {

struct LocalEquation {
  std::vector<double> known, low, high; ///< b and the box
  double factor = 0.0;                  ///< c
  /// g(z), and its derivatives row by row.
  std::function<void(std::span<const double> z, std::span<double> g)> rates;
  std::function<void(std::span<const double> z, std::span<double> by_state)> derivatives;
  /// sum_j |dg_i/da_j a_j|, a all that the rates read besides time and place: rates of differences,
  /// as that of a stress above its threshold, are known to the rounding of this. None: of g itself.
  std::function<void(std::span<const double> z, std::span<double> terms)> terms{};
};

/// Solves from z, in place, to rounding, of several equations to that of their terms. One equation:
/// the first solution met from z on in the direction in which its residual falls, by a bracket,
/// Newton's method and bisection. Several: Newton's method with steps halved until the residual
/// falls, else one equation after the other. False where none was found.
bool solve_local(const LocalEquation& equation, std::span<double> z);

} // namespace hvi::solver
