// Symbolic recognition of kernels that a recursion computes exactly: sums of
//   c g(t) h(s) lag^r exp(p lag + sigma t),   c, p, sigma complex,
// read off the expression in whatever way it is written.
#pragma once

#include "solver/kernel/expr.hpp"
#include "solver/kernel/prony_series.hpp"

#include <complex>
#include <optional>
#include <vector>

namespace hvi::solver {

using Complex = std::complex<double>;

/// The slot that stands for s = t - lag in `ExponentialTerm::of_source`.
inline constexpr Slot source_slot = slot::x(0);

/// One term. Complex terms come in conjugate pairs (the kernel is real).
struct ExponentialTerm {
  Complex factor = 1.0;
  int power = 0;           ///< of the lag
  Complex lag_rate = 0.0;  ///< p
  Complex time_rate = 0.0; ///< sigma
  Expr of_time = 1.0;      ///< g, of slot::t
  Expr of_source = 1.0;    ///< h, of source_slot
};
using ExponentialTerms = std::vector<ExponentialTerm>;

/// The terms of a kernel in (t, lag), like terms collected; none when it is not such a sum or has
/// too many terms to be worth it. The identity is algebraic; callers check it numerically.
std::optional<ExponentialTerms> exponential_terms(const Expr& kernel);
/// Those of a kernel that was written as a Prony series: nothing to recognise.
ExponentialTerms exponential_terms(const PronySeries& series);

/// The value of the sum at (t, lag).
double evaluate(const ExponentialTerms& terms, double t, double lag);

} // namespace hvi::solver
