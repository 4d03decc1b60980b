// H(f): is a load square integrable in time? Read off its expression.
#pragma once

#include "solver/kernel/expr.hpp"

#include <optional>
#include <vector>

namespace hvi::solver {

/// |f| ~ |t - at|^-exponent. Square integrable there when 2 exponent < 1.
struct TimeSingularity {
  double at = 0, exponent = 0;
  bool square_integrable() const { return exponent < 0.5; }
};

/// The worst time in [t0, t1] at which the expression is not bounded, wherever it is asked; nothing
/// where none is found. Found are zeros of bases of powers, of denominators, and of arguments of
/// logarithms that are affine in t. A pole that moves is one of space (load_space.hpp).
std::optional<TimeSingularity> time_singularity(const Expr& f, double t0, double t1);

/// -d log|f| / d log d as d -> 0, the one variable of f; at least 0.
double exponent_of_growth(const Expr& f);

} // namespace hvi::solver
