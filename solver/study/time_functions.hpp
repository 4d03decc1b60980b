// The functions of time in a plan: what multiplies what in space is taken apart first.
#pragma once

#include "solver/plan/problem.hpp"

#include <vector>

namespace hvi::solver {

struct TimeFunction {
  Expr f;              ///< of slot::t only
  double weight = 1.0; ///< the largest value of what multiplies it in space
  enum class Kind { load, imposed, law, kernel } kind = Kind::load;
  /// Of a function of x and t that does not separate: this is what one point sees of it, and
  /// functions with the same number belong together. 0: all points see this one.
  int group = 0;
};

/// All functions of t in loads, imposed values, offsets and expressions of laws, and kernels.
std::vector<TimeFunction> time_functions(const Problem& problem);

/// Lags at which the kernels of a plan have a kink or a jump, sorted.
std::vector<double> kernel_breaks(const Problem& problem);

} // namespace hvi::solver
