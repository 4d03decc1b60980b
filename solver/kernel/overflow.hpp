// Quotients of exponentials, so written that numerator and denominator do not overflow together.
#pragma once

#include "solver/kernel/expr.hpp"

namespace hvi::solver {

/// An equal expression in which exponentials stand inside the sums they are divided by:
/// exp(a) / (1 + exp(a))^2 is 1 / (exp(-a/2) + exp(a/2))^2, sinh(a) / cosh(a)^2 is
/// tanh(a) / cosh(a). Where a is large the first ones are infinity over infinity, of which
/// neither intervals nor rules of growth know anything. Without such quotients: `e` itself.
Expr without_overflow(const Expr& e);

} // namespace hvi::solver
