// w_n(x) = exp(x^2) i^n erfc(x), the scaled repeated integrals of the complementary error function:
//   w_n(x) = 2 / (sqrt(pi) n!) int_0^oo s^n exp(-s^2 - 2 s x) ds > 0,
//   2 n w_n = w_{n-2} - 2 x w_{n-1},   w_{-1} = 2 / sqrt(pi),   w_n' = -2 (n + 1) w_{n+1}.
// For x < 0 all terms of the recurrence have one sign, and it is used upwards. For x > 0 the other
// solution, w_n(-x), grows over w_n(x) by exp(2 x sqrt(2 n)): ratios of neighbours come from the
// continued fraction (W. Gautschi, Computational aspects of three-term recurrence relations, SIAM
// Rev. 9 (1967) 24-82, section 5), and near 0 the Taylor series takes over.
#include "solver/kernel/scalar.hpp"

#include <numbers>
#include <utility>

namespace hvi::solver {

namespace {

constexpr int largest_order = 100;
constexpr double before_zeroth = 2.0 * std::numbers::inv_sqrtpi; // w_{-1}

/// exp(x^2), with what the square loses in rounding: x^2 2^-53 would be many digits of it.
double exp_of_square(double x) {
  const double square = x * x;
  if (!(square < 750.0)) return square * infinity; // NaN stays NaN
  return std::exp(square) * (1.0 + std::fma(x, x, -square));
}

/// w_n = w_{-1} r_0 ... r_n with r_k = w_k / w_{k-1} = 1 / (2 (x + (k + 1) r_{k+1})). Starting
/// from r_m = 0 leaves an error of exp(-2 x (sqrt(2 m) - sqrt(2 n))) where m is above x^2, and
/// each further step takes a factor below m / (2 x^2) where it is not: 1e-17 here.
double by_ratios(int n, double x) {
  const double depth = std::sqrt(static_cast<double>(n)) + 14.0 / x;
  double ratio = 0.0, result = before_zeroth;
  for (int k = static_cast<int>(depth * depth) + 12; k >= 0; --k) {
    ratio = 0.5 / (x + (k + 1) * ratio);
    if (k <= n) result *= ratio;
  }
  return result;
}

/// sum_k (-2 x)^k (n + 1) ... (n + k) / k! w_{n+k}(0), w_m(0) = 2^-m / Gamma(m/2 + 1). Neighbours
/// of even and of odd k follow from w_m(0) = w_{m-2}(0) / (2 m).
double by_taylor(int n, double x) {
  const auto at_zero = [](int m) { return std::ldexp(1.0 / std::tgamma(0.5 * m + 1.0), -m); };
  double here = at_zero(n), next = at_zero(n + 1), factor = 1.0, sum = 0.0;
  for (int k = 0; k < 200; ++k) {
    const double term = factor * here;
    sum += term;
    if (std::abs(term) < 1e-18 * sum) break;
    factor *= -2.0 * x * (n + k + 1) / (k + 1);
    here = std::exchange(next, here / (2.0 * (n + k + 2)));
  }
  return sum;
}

double upwards(int n, double x) {
  double before = before_zeroth, now = erfcx(0.0, x);
  for (int k = 1; k <= n; ++k) before = std::exchange(now, (before - 2.0 * x * now) / (2.0 * k));
  return now;
}

/// exp(x^2) erfc(x) as it stands, where erfc is far from the least numbers.
double zeroth(double x) {
  constexpr double far = 4.0;
  if (x < 0.0) return 2.0 * exp_of_square(x) - zeroth(-x);
  return x < far ? exp_of_square(x) * std::erfc(x) : by_ratios(0, x);
}

} // namespace

double erfcx(double order, double x) {
  if (std::isnan(x) || !(order >= 0.0 && order <= largest_order) || order != std::trunc(order))
    return not_a_number;
  const int n = static_cast<int>(order);
  if (n == 0) return zeroth(x);
  if (x < 0.0) return upwards(n, x);
  return x * std::sqrt(n + 1.0) < 0.5 ? by_taylor(n, x) : by_ratios(n, x);
}

} // namespace hvi::solver
