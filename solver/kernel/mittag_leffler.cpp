// The Mittag-Leffler function E_{alpha,beta}(x) = sum_k x^k / Gamma(alpha k + beta) for real x:
//   near 0    the series itself,
//   elsewhere the inverse Laplace transform of s^(alpha-beta) / (s^alpha - x) at time 1, less the
//             first m terms -x^-k / Gamma(beta - alpha k) of the expansion at infinity, which are
//             added in closed form. The rest is small, so that the sum keeps its relative accuracy;
//             for large |x| it is zero.
// With s = w^2 the integration line is Re w = c, a parabola in s, and the integrand is analytic in
// Re w > 0 up to the poles w^(2 alpha) = x. The trapezoidal rule then converges like
// exp(-2 pi c / h), and its error by a pole is known exactly.
//
// Parabolic contours: J. A. C. Weideman, L. N. Trefethen, Parabolic and hyperbolic contours for
// computing the Bromwich integral, Math. Comp. 76 (2007) 1341-1356; for this function R. Garrappa,
// Numerical evaluation of two and three parameter Mittag-Leffler functions, SIAM J. Numer. Anal. 53
// (2015) 1350-1369. The rule: L. N. Trefethen, J. A. C. Weideman, The exponentially convergent
// trapezoidal rule, SIAM Rev. 56 (2014) 385-458.
#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <complex>
#include <limits>
#include <numbers>

namespace hvi::solver {

namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double largest_beta = 100.0; ///< 1 / Gamma(beta) must stay far from underflow
constexpr double series_radius = 0.1;
constexpr double decay = 42.0; ///< exponent to which errors are pressed: e^-42 = 6e-19
constexpr double asymptotic_exponent =
    45;                               ///< |x|^(1/alpha) - 2 beta beyond which no integral is needed
constexpr double pole_distance = 0.3; ///< least distance of a pole from the line, in w

double reciprocal_gamma(double z) {
  if (z <= 0.0 && z == std::trunc(z)) return 0.0;
  if (z > -170.0) return 1.0 / std::tgamma(z);
  // 1 / Gamma(z) = sin(pi z) Gamma(1 - z) / pi
  return std::sin(pi * std::fmod(z, 2.0)) / pi * std::exp(std::lgamma(1.0 - z));
}

double power_series(double alpha, double beta, double x) {
  double sum = 0.0, power = 1.0;
  for (int k = 0; k < 40; ++k, power *= x) {
    const double term = power * reciprocal_gamma(alpha * k + beta);
    sum += term;
    if (power == 0.0 || (k > 2 && std::abs(term) < 1e-18 * std::abs(sum))) break;
  }
  return sum;
}

/// The transform without `terms` terms of the expansion at infinity, as an integral along
/// Re w = line.
struct Inversion {
  double alpha, beta, x, line;
  int terms;

  /// 2 w e^s s^(alpha-beta) (s^alpha / x)^terms / (s^alpha - x), s = w^2
  Complex integrand(Complex w) const {
    const Complex log_s = 2.0 * std::log(w), power = std::exp(alpha * log_s);
    const double sign = (x < 0.0 && terms % 2 == 1) ? -1.0 : 1.0;
    const Complex exponent = w * w + (alpha - beta) * log_s +
                             static_cast<double>(terms) * (alpha * log_s - std::log(std::abs(x)));
    return sign * 2.0 * w * std::exp(exponent) / (power - x);
  }

  /// Half the width of the strip left of the line in which the integrand is used to be analytic.
  double strip() const { return std::min(0.75 * line, 1.5); }

  double step() const {
    // By how much the integrand may grow towards the left edge of the strip, as an exponent.
    const double edge = line - strip();
    const double growth =
        2.0 * (beta - alpha * (terms + 1)) * std::log(line / edge) - (line * line - edge * edge);
    return 2.0 * pi * strip() / (decay + std::max(0.0, growth));
  }

  /// (1 / 2 pi) times the integral over the line, by the trapezoidal rule.
  double integral() const {
    const double h = step(), past_peak = alpha * terms + std::max(0.0, alpha - beta) + 4.0;
    double sum = 0.0, largest = 0.0;
    for (int k = 0; k < 4000; ++k) {
      const double v = (k + 0.5) * h;
      const Complex f = integrand({line, v});
      sum += f.real();
      largest = std::max(largest, std::abs(f));
      if (v * v > past_peak && std::abs(f) < 1e-18 * largest) break;
    }
    return sum * h / pi; // the other half of the line is the conjugate
  }

  /// The residue of the pole s (in s) times the share that the trapezoidal sum does not yet hold:
  /// all of it far to the right of the line, nothing to the left of the strip.
  double residue(Complex s) const {
    if (std::sqrt(s).real() <= line - strip()) return 0.0;
    const Complex share = 1.0 / (1.0 + std::exp(-2.0 * pi * (std::sqrt(s) - line) / step()));
    return (std::exp(s + (1.0 - beta) * std::log(s)) * share).real() / alpha;
  }
};

/// The pole of the principal sheet with Im s >= 0, if there is one. For x < 0 and alpha > 1 its
/// conjugate is another one.
struct Pole {
  bool exists = false, pair = false;
  Complex s;
};

Pole pole_of(double alpha, double x) {
  const double radius = std::pow(std::abs(x), 1.0 / alpha);
  if (x > 0.0) return {true, false, radius};
  if (alpha <= 1.0) return {};
  return {true, true, std::polar(radius, pi / alpha)};
}

/// -sum_{k = 1}^{terms} x^-k / Gamma(beta - alpha k)
double expansion_at_infinity(double alpha, double beta, double x, int terms) {
  double sum = 0.0, power = 1.0;
  for (int k = 1; k <= terms; ++k) {
    power /= x;
    sum -= power * reciprocal_gamma(beta - alpha * k);
  }
  return sum;
}

/// A line near the saddle `where` of the integrand that keeps its distance from the pole.
double integration_line(double where, const Pole& pole) {
  const double best = std::sqrt(std::max(1.0, where));
  if (!pole.exists) return best;
  const double p = std::sqrt(pole.s).real();
  if (std::abs(p - best) >= pole_distance) return best;
  return p > best ? p - pole_distance : p + pole_distance;
}

/// How many terms of the expansion at infinity are worth taking out. They fall from the first one
/// on when |x|^(1/alpha) > beta, faster beyond 2 beta, until alpha k reaches |x|^(1/alpha) (+ beta,
/// roughly).
int expansion_terms(double alpha, double beta, double radius, bool far) {
  if (radius < std::max(1.0, 2.0 * beta)) return 0;
  const double reach = far ? asymptotic_exponent + std::max(0.0, beta) : 0.7 * radius;
  return static_cast<int>(std::min(reach / alpha, 1000.0));
}

double beyond_series(double alpha, double beta, double x) {
  const double radius = std::pow(std::abs(x), 1.0 / alpha);
  if (x > 0.0 && (radius > 1e300 || radius + (1.0 - beta) * std::log(radius) > 720.0))
    return std::numeric_limits<double>::infinity(); // E ~ x^((1-beta)/alpha) e^radius / alpha
  const bool far = radius > asymptotic_exponent + 2.0 * std::max(0.0, beta);
  const int terms = expansion_terms(alpha, beta, radius, far);
  const Pole pole = pole_of(alpha, x);
  const Inversion inversion{alpha, beta, x, integration_line(beta - alpha * terms, pole), terms};
  double value = expansion_at_infinity(alpha, beta, x, terms);
  if (!far) value += inversion.integral();
  if (pole.exists) value += (pole.pair ? 2.0 : 1.0) * inversion.residue(pole.s);
  return value;
}

} // namespace

double mittag_leffler(double alpha, double beta, double x) {
  if (!(alpha > 0.0 && alpha <= 2.0) || !(std::abs(beta) <= largest_beta) || std::isnan(x))
    return not_a_number;
  // No expansion at infinity exists here, only x^(1-beta) e^x.
  if (alpha == 1.0 && beta <= 1.0 && beta == std::trunc(beta))
    return std::exp(x) * std::pow(x, 1.0 - beta);
  if (std::abs(x) <= series_radius) return power_series(alpha, beta, x);
  return beyond_series(alpha, beta, x);
}

} // namespace hvi::solver
