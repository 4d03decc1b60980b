// A convolution kernel on [low, high] as quadrature points that resolve it, and norms over them.
#pragma once

#include "solver/history/prepared.hpp"

#include <optional>
#include <vector>

namespace hvi::solver {

/// Gauss points on panels, each short enough that polynomials reproduce the kernel within what the
/// tolerance allows there.
struct KernelSamples {
  double low = 0, high = 0;
  double norm = 0; ///< int_0^high |q|
  std::vector<double> lag, value, weight;
  std::vector<double> panel_ends; ///< panels + 1

  /// m(lag), int m ~ 2: an error tolerance * norm * m(lag) / 2 everywhere is an L1 error of
  /// tolerance * norm. Larger towards small lags, where an error weighs little.
  double density(double lag) const;
};

/// None if more than `max_points` are needed (fast oscillation, kinks).
std::optional<KernelSamples> sample_kernel(const PreparedKernel& kernel, double low, double high,
                                           double tolerance, std::size_t max_points);

} // namespace hvi::solver
