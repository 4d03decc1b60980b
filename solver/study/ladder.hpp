// Rungs of a study: which settings, what order is seen between them, which no other one beats.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// Every combination of the rungs of the ladders, as indices; the last ladder varies fastest.
std::vector<std::vector<int>> combinations(std::span<const int> rungs);

/// log(e_coarse / e_fine) / log(ratio): how the error falls when the parameter grows by `ratio`.
std::optional<double> observed_order(double coarse_error, double fine_error, double ratio);

/// Which points (cost, error) no other beats in both: the front.
std::vector<bool> pareto_front(std::span<const double> cost, std::span<const double> error);

/// What distances to the finest run say of the errors themselves, error_i = c s_i^-p (s_i: the
/// parameter's value relative to the finest). Either the finest error is a part of the others,
/// distance_i = error_i - error_finest (errors in time), or it is orthogonal to the distance,
/// distance_i^2 = error_i^2 - error_finest^2 (Galerkin errors in space): p and c by least squares
/// on the logarithms, with the relation that fits better. Needs two distances; `errors` then has an
/// entry for the finest, too.
struct Richardson {
  double order = 0.0;
  std::vector<double> errors;
};
std::optional<Richardson> richardson(std::span<const double> scales,
                                     std::span<const double> distances);

} // namespace hvi::solver
