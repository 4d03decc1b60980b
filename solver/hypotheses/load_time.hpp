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

/// The worst place in [t0, t1] where the expression is not bounded; nothing where none is found.
/// Found are zeros of bases of powers, of denominators, and of arguments of logarithms that are
/// affine in t. Other slots are taken at `others`.
std::optional<TimeSingularity> time_singularity(const Expr& f, double t0, double t1,
                                                double others = 0.37);

} // namespace hvi::solver
