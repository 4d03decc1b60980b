// A Prony series through tabulated relaxation data.
#pragma once

#include "solver/kernel/prony_series.hpp"
#include "solver/kernel/table.hpp"

namespace hvi::solver {

/// All weights of one sign, so that the material dissipates whatever happens to it.
struct PronyFit {
  PronySeries series;
  double largest = 0; ///< max |series - data| over the points, relative to max |data|
  double mean = 0;    ///< root mean square of the same
};

/// Least squares over the table's points with relaxation times on a logarithmic grid (twenty a
/// decade, from half the least spacing to ten times the range), by the active-set method for
/// weights that may not change sign (C. L. Lawson, R. J. Hanson, Solving least squares problems,
/// 1974, chapter 23).
PronyFit fit_prony(const Table& table);

} // namespace hvi::solver
