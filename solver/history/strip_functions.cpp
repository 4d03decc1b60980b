// Ends are not rounded outwards: the bounds decide how a panel is cut, and a factor does not
// matter.
#include "solver/history/strip_functions.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hvi::solver {
namespace strips {

namespace {

constexpr double pi = std::numbers::pi;

struct Range {
  double low, high;
};

Range product(Range a, Range b) {
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  return {std::min({p, q, r, s}), std::max({p, q, r, s})};
}

double largest(const Strip& z) { return std::max(std::abs(z.low), std::abs(z.high)); }
double least(const Strip& z) { return z.low > 0 ? z.low : z.high < 0 ? -z.high : 0.0; }

Range ordered(double a, double b) { return {std::min(a, b), std::max(a, b)}; }

/// modulus in [r.low, r.high], |argument| <= angle.
Strip polar(Range r, double angle, Range on_line) {
  const double c = std::cos(std::min(angle, pi));
  return {c >= 0 ? r.low * c : r.high * c,
          r.high,
          r.high * (angle < pi / 2 ? std::sin(angle) : 1.0),
          on_line.low,
          on_line.high,
          State::analytic};
}

Strip square(const Strip& z) {
  const double big = largest(z), small = least(z), y = z.imaginary;
  const double line = std::max(std::abs(z.real_low), std::abs(z.real_high));
  const double near = z.real_low > 0 ? z.real_low : z.real_high < 0 ? -z.real_high : 0.0;
  return {small * small - y * y, big * big, 2 * big * y, near * near, line * line, State::analytic};
}

Strip whole_power(const Strip& z, int n) {
  if (n < 0) return checked(reciprocal(whole_power(z, -n)));
  if (n == 0) return Strip::exactly(1);
  if (n == 1) return z;
  if (z.low > 0) return right_power(z, n);
  if (z.high < 0) {
    const Strip p = right_power(negate(z), n);
    return n % 2 == 0 ? p : negate(p);
  }
  const Strip half = whole_power(z, n / 2), even = square(half);
  return n % 2 == 0 ? even : multiply(even, z);
}

/// Range of cos over [a, b].
Range cosine(double a, double b) {
  if (!(b - a < 2 * pi)) return {-1, 1};
  Range r = ordered(std::cos(a), std::cos(b));
  if (std::floor(b / (2 * pi)) > std::floor(a / (2 * pi))) r.high = 1;
  if (std::floor((b - pi) / (2 * pi)) > std::floor((a - pi) / (2 * pi))) r.low = -1;
  return r;
}

/// f(c) + f'(Z) (Z - c) with c real: holds for each of the two parts.
template <class F>
Strip mean_value(const Strip& z, const Strip& slope, const F& f) {
  if (slope.state != State::analytic) return slope;
  const double c = 0.5 * (z.real_low + z.real_high);
  return add(Strip::exactly(f(c)), multiply(slope, add(z, Strip::exactly(-c))));
}

/// side + a disc of radius `off`.
Strip beside(double side, double off) {
  return {side - off, side + off, off, side - off, side + off, State::analytic};
}

Strip ball(double radius) { return {-radius, radius, radius, -radius, radius, State::analytic}; }

} // namespace

Strip nothing(State state) { return {-infinity, infinity, infinity, -infinity, infinity, state}; }

Strip checked(const Strip& z) {
  const bool finite = std::isfinite(z.low) && std::isfinite(z.high) && std::isfinite(z.imaginary) &&
                      std::isfinite(z.real_low) && std::isfinite(z.real_high);
  return finite ? z : nothing(std::max(z.state, State::singular));
}

Strip add(const Strip& a, const Strip& b) {
  return {a.low + b.low,           a.high + b.high,           a.imaginary + b.imaginary,
          a.real_low + b.real_low, a.real_high + b.real_high, State::analytic};
}

Strip negate(const Strip& a) {
  return {-a.high, -a.low, a.imaginary, -a.real_high, -a.real_low, State::analytic};
}

Strip multiply(const Strip& a, const Strip& b) {
  const Range re = product({a.low, a.high}, {b.low, b.high});
  const Range on_line = product({a.real_low, a.real_high}, {b.real_low, b.real_high});
  const double im = a.imaginary * b.imaginary;
  return {re.low - im, re.high + im, largest(a) * b.imaginary + largest(b) * a.imaginary,
          on_line.low, on_line.high, State::analytic};
}

/// x / (x^2 + y^2) and y / (x^2 + y^2) for x > 0.
Strip reciprocal(const Strip& z) {
  if (z.high < 0) return negate(reciprocal(negate(z)));
  if (!(z.low > 0)) return nothing(State::singular);
  const double y = z.imaginary;
  const auto part = [&](double x) { return 1 / (x + y * (y / x)); };
  const double im = y <= z.low ? (y / z.low) * part(z.low) : 0.5 / z.low;
  return {std::min(part(z.low), part(z.high)),
          1 / z.low,
          im,
          1 / z.real_high,
          1 / z.real_low,
          State::analytic};
}

Strip right_power(const Strip& z, double c) {
  const Range modulus = ordered(std::pow(z.low, c), std::pow(std::hypot(z.high, z.imaginary), c));
  return polar(modulus, std::abs(c) * std::atan2(z.imaginary, z.low),
               ordered(std::pow(z.real_low, c), std::pow(z.real_high, c)));
}

Strip exponential(const Strip& z) {
  const double small = std::exp(z.low), big = std::exp(z.high);
  return polar({small, big}, z.imaginary, {std::exp(z.real_low), std::exp(z.real_high)});
}

Strip logarithm(const Strip& z) {
  if (!(z.low > 0)) return nothing(State::singular);
  return {std::log(z.low),
          std::log(std::hypot(z.high, z.imaginary)),
          std::atan2(z.imaginary, z.low),
          std::log(z.real_low),
          std::log(z.real_high),
          State::analytic};
}

Strip power(const Strip& base, const Strip& exponent) {
  if (exponent.low == exponent.high && exponent.imaginary == 0) {
    const double c = exponent.low;
    if (is_multiplied_power(c)) return whole_power(base, static_cast<int>(c));
    return base.low > 0 ? right_power(base, c) : nothing(State::singular);
  }
  if (!(base.low > 0)) return nothing(State::singular);
  return exponential(multiply(exponent, logarithm(base)));
}

/// cos(x + i y) = cos x cosh y - i sin x sinh y.
Strip cosine(const Strip& z) {
  const double grow = std::cosh(z.imaginary);
  const Range c = cosine(z.low, z.high), line = cosine(z.real_low, z.real_high);
  const Range re = product(c, {1, grow});
  return {re.low, re.high, std::sinh(z.imaginary), line.low, line.high, State::analytic};
}

Strip sine(const Strip& z) { return cosine(add(z, Strip::exactly(-pi / 2))); }

Strip hyperbolic(const Strip& z, bool even) {
  const Strip plus = exponential(z), minus = exponential(negate(z));
  return multiply(Strip::exactly(0.5), add(plus, even ? minus : negate(minus)));
}

/// tanh z = 1 - 2 / (exp(2 z) + 1).
Strip tangent_hyperbolic(const Strip& z) {
  const double decay = std::exp(-2 * least(z)), off = 2 * decay / (1 - decay);
  if (off < 0.5) return beside(z.low > 0 ? 1.0 : -1.0, off);
  if (!(z.imaginary < 1.5)) return nothing(State::singular);
  const Strip slope = reciprocal(square(hyperbolic(z, true)));
  return mean_value(z, slope, [](double x) { return std::tanh(x); });
}

Strip arctangent(const Strip& z) {
  const Strip slope = reciprocal(add(Strip::exactly(1), square(z)));
  return mean_value(z, slope, [](double x) { return std::atan(x); });
}

Strip error_function(const Strip& z) {
  // Where the real part is large erf is 1 - erfc, |erfc(z)| <= |exp(-z^2)| for Re z >= 0.
  const Strip gauss = exponential(negate(square(z)));
  if (least(z) > 0) {
    const double off = gauss.modulus(), side = z.low > 0 ? 1.0 : -1.0;
    if (off < 0.1) return beside(side, off);
  }
  const Strip slope = multiply(Strip::exactly(2 / std::sqrt(pi)), gauss);
  return mean_value(z, slope, [](double x) { return std::erf(x); });
}

/// A mixture of exp(-s z), s >= 0 (solver/kernel/erfcx.cpp): the modulus is at most that of Re z.
Strip scaled_error(const Strip& order, const Strip& z) {
  if (!is_number(order)) return nothing(State::unknown);
  const auto value = [&](double x) { return erfcx(order.low, x); };
  Strip out = ball(value(z.low));
  out.real_low = value(z.real_high);
  out.real_high = value(z.real_low);
  return out;
}

Strip error_left(const Strip& z) {
  Strip out;
  if (z.low >= 0)
    out = multiply(exponential(negate(square(z))), scaled_error(Strip::exactly(0), z));
  else if (z.high <= 0)
    out = add(Strip::exactly(2), negate(error_left(negate(z))));
  else
    out = add(Strip::exactly(1), negate(error_function(z)));
  out.real_low = std::erfc(z.real_high);
  out.real_high = std::erfc(z.real_low);
  return out;
}

Strip arcsine(const Strip& z) {
  const Strip inside = add(Strip::exactly(1), negate(square(z)));
  if (!(inside.low > 0)) return nothing(State::singular);
  return mean_value(z, right_power(inside, -0.5), [](double x) { return std::asin(x); });
}

/// E_{a,b}(-x) is completely monotone for 0 < a <= 1, b >= a, a mixture of exp(-x u), u >= 0
/// (W. R. Schneider's theorem; see T. Simon, Mittag-Leffler functions and complete
/// monotonicity, arXiv:1312.4513, 2013): |E(z)| <= E(Re z).
Strip mittag_leffler(const Strip& a, const Strip& b, const Strip& z) {
  if (!is_number(a) || !is_number(b)) return nothing(State::unknown);
  if (!(a.low > 0 && a.low <= 1 && b.low >= a.low)) return nothing(State::unknown);
  const auto value = [&](double x) { return hvi::solver::mittag_leffler(a.low, b.low, x); };
  Strip out = ball(value(z.high));
  out.real_low = value(z.real_low); // it increases with x
  out.real_high = value(z.real_high);
  return out;
}

/// |J_n(z)| <= exp(|Im z|) for whole n (from Bessel's integral).
Strip bessel(const Strip& order, const Strip& z) {
  if (!is_number(order) || order.low != std::round(order.low)) return nothing(State::unknown);
  Strip out = ball(std::exp(z.imaginary));
  const double middle = 0.5 * (z.real_low + z.real_high), half = z.real_high - middle;
  const double value = hvi::solver::bessel_j(order.low, middle); // its slope is at most 1
  out.real_low = value - half;
  out.real_high = value + half;
  return out;
}

/// Within one piece of the table a polynomial of degree at most 3: on the ellipse it exceeds its
/// largest value on the piece by less than ellipse^3.
Strip tabulated(const Table& table, const Strip& z, bool slope) {
  const auto& x = table.abscissae();
  const double low = std::max(z.real_low, x.front()), high = std::min(z.real_high, x.back());
  if (!(low <= high)) return nothing(State::singular);
  const double slack = 1e-13 * std::max(std::abs(x.front()), std::abs(x.back()));
  const auto next = std::upper_bound(x.begin(), x.end(), low + slack);
  if (next != x.end() && *next < high - slack) return nothing(State::singular);
  const auto [least_value, largest_value] = table.range(low, high, slope);
  Strip out = ball(16 * std::max(std::abs(least_value), std::abs(largest_value)));
  out.real_low = least_value;
  out.real_high = largest_value;
  return out;
}

} // namespace strips

double Strip::modulus() const {
  return state == State::analytic ? std::hypot(strips::largest(*this), imaginary) : infinity;
}

} // namespace hvi::solver
