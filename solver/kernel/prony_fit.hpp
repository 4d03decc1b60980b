// A Prony sum through tabulated relaxation data.
#pragma once

#include "solver/kernel/table.hpp"

#include <vector>

namespace hvi::solver {

/// constant + sum_i weights[i] exp(-x / times[i]): all weights of one sign, so that the material
/// dissipates whatever happens to it.
struct PronySum {
  double constant = 0;
  std::vector<double> weights, times;
  double largest = 0; ///< max |sum - data| over the points, relative to max |data|
  double mean = 0;    ///< root mean square of the same
  double value(double x) const;
};

/// Least squares over the table's points with relaxation times on a logarithmic grid (twenty a
/// decade, from half the least spacing to ten times the range), by the active-set method for
/// weights that may not change sign (C. L. Lawson, R. J. Hanson, Solving least squares problems,
/// 1974, chapter 23).
PronySum fit_prony(const Table& table);

} // namespace hvi::solver
