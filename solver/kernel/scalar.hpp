// The one place that says what each operation means for numbers: Expr::evaluate, constant folding
// and the tape all call it, so that they agree to the last bit.
#pragma once

#include "solver/common/numbers.hpp"
#include "solver/kernel/expr.hpp"

#include <cmath>
#include <limits>

namespace hvi::solver {

/// Integer exponents up to this size are repeated multiplication.
inline constexpr int largest_multiplied_power = 64;

/// Special functions, see special.cpp, erfcx.cpp and mittag_leffler.cpp. Outside the domain: NaN.
double bessel_j(double order, double x);
double polygamma(double order, double x);
/// exp(x^2) i^n erfc(x), i^n the repeated integral from x to infinity; n = 0, 1, .., 100.
double erfcx(double order, double x);
/// E_{alpha,beta}(x) for real x, 0 < alpha <= 2, |beta| <= 100.
double mittag_leffler(double alpha, double beta, double x);

inline bool is_multiplied_power(double exponent) {
  return std::abs(exponent) <= largest_multiplied_power && exponent == std::trunc(exponent);
}

/// x^n by squaring; a negative power is the reciprocal of the positive one.
inline double integer_power(double x, int n) {
  double result = 1.0, square = x;
  for (unsigned k = static_cast<unsigned>(n < 0 ? -n : n); k != 0; k >>= 1) {
    if (k & 1U) result *= square;
    if (k > 1) square *= square;
  }
  return n < 0 ? 1.0 / result : result;
}

inline double scalar_power(double x, double exponent) {
  if (is_multiplied_power(exponent)) return integer_power(x, static_cast<int>(exponent));
  return std::pow(x, exponent);
}

/// NaN wins over numbers, unlike in std::min.
inline double scalar_min(double a, double b) { return (a < b || a != a) ? a : b; }
inline double scalar_max(double a, double b) { return (a > b || a != a) ? a : b; }
inline double scalar_sign(double a) { return a > 0.0 ? 1.0 : (a < 0.0 ? -1.0 : a); }

// Truth as a number: 1, 0, or NaN for unknown.
inline double scalar_less(double a, double b) {
  return a < b ? 1.0 : (a >= b ? 0.0 : not_a_number);
}
inline double scalar_less_equal(double a, double b) {
  return a <= b ? 1.0 : (a > b ? 0.0 : not_a_number);
}
inline double scalar_equal(double a, double b) {
  return a == b ? 1.0 : ((a < b || a > b) ? 0.0 : not_a_number);
}
inline double scalar_not(double a) { return a == 0.0 ? 1.0 : (a != a ? a : 0.0); }
inline double scalar_and(double a, double b) {
  return (a == 0.0 || b == 0.0) ? 0.0 : ((a != a || b != b) ? not_a_number : 1.0);
}
inline double scalar_or(double a, double b) {
  const bool yes = (a != 0.0 && a == a) || (b != 0.0 && b == b);
  return yes ? 1.0 : ((a != a || b != b) ? not_a_number : 0.0);
}
inline double scalar_select(double c, double then, double otherwise) {
  return c != c ? c : (c != 0.0 ? then : otherwise);
}

/// The value of an operation (not a leaf, not a table) on numbers; unused arguments are ignored.
double apply(Op op, double a, double b, double c);

} // namespace hvi::solver
