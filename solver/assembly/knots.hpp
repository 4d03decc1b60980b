// Times at which a function of time has a kink or a jump.
#pragma once

#include "solver/kernel/expr.hpp"

#include <vector>

namespace hvi::solver {

struct Knots {
  std::vector<double> times;
  std::vector<Expr> signs; ///< functions of t, which has others where they change their sign
};

/// Knots of tables of t, and where comparisons, min, max, abs and sign of t change sides: the mean
/// is that of a smooth function between them.
void collect_knots(const Expr& expression, Knots& knots);

} // namespace hvi::solver
