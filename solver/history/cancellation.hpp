// Kernels written with t and s, in a form that keeps its digits where the lag is small beside t.
#pragma once

#include "solver/kernel/expr.hpp"

namespace hvi::solver {

/// The same function of (t, lag): differences f(t) - f(t - lag) are rewritten so that the lag is a
/// factor: t^2 - s^2 = lag (t + s), log t - log s = log(1 + lag/s). As written they lose all digits
/// where lag/t is rounding: over ten decades of time a kernel of a reduced time xi(t) - xi(s) would
/// be noise, and (t^2 - s^2)^(-1/2) infinite near lag 0.
Expr without_cancellation(const Expr& kernel);

} // namespace hvi::solver
