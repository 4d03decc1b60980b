// Rungs of a study: which settings, what order is seen between them, which no other one beats.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// Every combination of the rungs of the ladders, as indices; the last ladder varies fastest.
std::vector<std::vector<int>> combinations(std::span<const int> rungs);

/// log(e_coarse / e_fine) / log(ratio): how the error falls when the resolution grows by `ratio`.
std::optional<double> observed_order(double coarse_error, double fine_error, double ratio);

/// Which points (cost, error) no other beats in both: the front.
std::vector<bool> pareto_front(std::span<const double> cost, std::span<const double> error);

/// The distance of two runs of a ladder, of resolutions relative to the finest run's.
struct RungDistance {
  double coarse = 0.0, fine = 1.0, distance = 0.0;
};

/// What distances say of the errors themselves. The error at resolution s has two parts, which both
/// fall like s^-p: one of the same direction in all runs (errors in time, errors of values), and
/// one that is orthogonal to all that is coarser (errors of slopes in space: Galerkin); so
///
///   distance_ij^2 = a^2 (s_i^-2p - s_j^-2p) + b^2 (s_i^-p - s_j^-p)^2,  finest^2 = a^2 + b^2.
struct Richardson {
  double order = 0.0, finest = 0.0; ///< p, and the error of the finest run
  /// How much of a distance has the direction of b: 0 (error^2 = distance^2 + finest^2) to
  /// 1 (error = distance + finest).
  double along = 0.0;
  /// Of a run of the ladder at a distance from the finest one.
  double error(double distance) const;
};

/// Of numbers all is b, and two distances tell it. Norms need three: with those to the finest run
/// alone any split into a and b fits another order. Nothing where there are fewer, and where they
/// show no order.
enum class Measured { number, norm };
std::optional<Richardson> richardson(std::span<const RungDistance> distances, Measured measured);

} // namespace hvi::solver
