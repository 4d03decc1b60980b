// Times at which a function of time has a kink or a jump.
#pragma once

#include "solver/kernel/expr.hpp"

#include <vector>

namespace hvi::solver {

struct Knots {
  std::vector<double> times;
  bool hidden = false; ///< there are others, at times that no formula gives
};

/// Knots of tables of t, and where comparisons, min, max, abs and sign of t change sides: the mean
/// is exact between them.
void collect_knots(const Expr& expression, Knots& knots);

} // namespace hvi::solver
