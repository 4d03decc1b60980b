// Interval extensions of functions (interval_rules.hpp): monotone ones from their ends, the others
// from their turning points.
#include "solver/common/numbers.hpp"
#include "solver/kernel/interval_rules.hpp"
#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace hvi::solver::rules {

namespace {

using std::numbers::pi;

/// Beyond this the turning points of sin and cos cannot be told in floating point.
constexpr double largest_angle = 1e8;
/// Relative and absolute error granted to the special functions.
constexpr double special_error = 1e-11;
/// Of erfc and erfcx, which are small where they are accurate, too.
constexpr int special_ulps = 32;

Bounds clipped(Bounds b, double low, double high) {
  b.low = std::clamp(b.low, low, high);
  b.high = std::clamp(b.high, low, high);
  return b;
}

Bounds increasing(Op op, const Bounds& x) {
  return widened({apply(op, x.low, 0, 0), apply(op, x.high, 0, 0), x.known, x.defined},
                 library_ulps);
}

/// x cut to the domain [low, high]; nothing left: no bounds, undefined.
bool cut_to_domain(Bounds& x, double low, double high) {
  if (x.low < low || x.high > high) x.defined = false;
  if (x.high < low || x.low > high) return false;
  x = clipped(x, low, high);
  return true;
}

Bounds nowhere(const Bounds& x) { return {-infinity, infinity, x.known, false}; }

/// Is there a whole k with shift + 2 pi k in x (or nearly so: it errs towards yes)?
bool meets(const Bounds& x, double shift) {
  const double slack = 1e-15 * (std::abs(x.low) + std::abs(x.high)) + 1e-15;
  return std::floor((x.high - shift + slack) / (2.0 * pi)) >=
         std::ceil((x.low - shift - slack) / (2.0 * pi));
}

/// sin or cos; `top` is where it is 1.
Bounds wave(Op op, const Bounds& x, double top) {
  if (!(std::abs(x.low) < largest_angle && std::abs(x.high) < largest_angle))
    return {-1.0, 1.0, x.known, x.defined};
  const double a = apply(op, x.low, 0, 0), b = apply(op, x.high, 0, 0);
  const double low = meets(x, top + pi) ? -1.0 : std::min(a, b);
  const double high = meets(x, top) ? 1.0 : std::max(a, b);
  return clipped(widened({low, high, x.known, x.defined}, library_ulps), -1.0, 1.0);
}

Bounds tangent(const Bounds& x) {
  const bool far = !(std::abs(x.low) < largest_angle && std::abs(x.high) < largest_angle);
  if (far || meets(x, 0.5 * pi) || meets(x, -0.5 * pi)) return nowhere(x);
  return increasing(Op::tan, x);
}

Bounds even(Op op, const Bounds& x) { // cosh, abs: falling below 0, rising above
  const double a = apply(op, x.low, 0, 0), b = apply(op, x.high, 0, 0);
  const double low = x.contains(0.0) ? apply(op, 0.0, 0, 0) : std::min(a, b);
  const Bounds result{low, std::max(a, b), x.known, x.defined};
  return op == Op::abs ? result : clipped(widened(result, library_ulps), 1.0, infinity);
}

/// The ends in order, widened by the error of a special function.
Bounds between(double a, double b, const Bounds& x) {
  const double low = std::min(a, b), high = std::max(a, b);
  return {low - special_error * (std::abs(low) + 1.0),
          high + special_error * (std::abs(high) + 1.0), x.known, x.defined};
}

Bounds gamma(const Bounds& x) {
  constexpr double turning = 1.4616321449683623, least = 0.8856031944108886;
  if (x.low <= 0.0) return {-infinity, infinity, false, false}; // poles
  const double a = std::tgamma(x.low), b = std::tgamma(x.high);
  Bounds result = between(a, b, x);
  if (x.contains(turning)) result.low = std::min(result.low, least - special_error);
  return result;
}

/// Monotone in x > 0: digamma rises, its derivatives fall in size and alternate in sign.
Bounds polygamma_bounds(const Bounds& order, const Bounds& x) {
  if (!is_point(order) || x.low <= 0.0)
    return {-infinity, infinity, false, x.low > 0.0 && x.defined};
  const double a = polygamma(order.low, x.low), b = polygamma(order.low, x.high);
  if (std::isnan(a) || std::isnan(b)) return anything(x);
  return between(a, b, x);
}

/// A mixture of exp(-s x), s >= 0: above 0 and falling.
Bounds erfcx_bounds(const Bounds& order, const Bounds& x) {
  if (!is_point(order)) return anything(x);
  const double high = erfcx(order.low, x.low), low = erfcx(order.low, x.high);
  if (std::isnan(low) || std::isnan(high)) return anything(x);
  return clipped(widened({low, high, x.known, x.defined}, special_ulps), 0.0, infinity);
}

/// For 0 < alpha <= 1, beta >= alpha, E(-x) is completely monotone (W. R. Schneider's theorem; see
/// T. Simon, Mittag-Leffler functions and complete monotonicity, arXiv:1312.4513, 2013), so that E
/// rises everywhere.
Bounds mittag_leffler_bounds(const Bounds& alpha, const Bounds& beta, const Bounds& x) {
  const bool rises = is_point(alpha) && is_point(beta) && alpha.low > 0.0 && alpha.low <= 1.0 &&
                     beta.low >= alpha.low;
  if (!rises) return anything(x);
  return between(mittag_leffler(alpha.low, beta.low, x.low),
                 mittag_leffler(alpha.low, beta.low, x.high), x);
}

} // namespace

Bounds function(Op op, const Bounds& x) {
  Bounds d = x;
  switch (op) {
  case Op::abs:
  case Op::cosh:
    return even(op, x);
  case Op::sign:
    return {scalar_sign(x.low), scalar_sign(x.high), x.known, x.defined};
  case Op::exp:
    return clipped(increasing(op, x), 0.0, infinity);
  case Op::log:
    if (d.low == 0.0) d.defined = false;
    return cut_to_domain(d, 0.0, infinity) ? increasing(op, d) : nowhere(x);
  case Op::sqrt:
    if (!cut_to_domain(d, 0.0, infinity)) return nowhere(x);
    return clipped(increasing(op, d), 0.0, infinity);
  case Op::sin:
    return wave(op, x, 0.5 * pi);
  case Op::cos:
    return wave(op, x, 0.0);
  case Op::tan:
    return tangent(x);
  case Op::asin:
    return cut_to_domain(d, -1.0, 1.0) ? increasing(op, d) : nowhere(x);
  case Op::acos:
    if (!cut_to_domain(d, -1.0, 1.0)) return nowhere(x);
    return widened({std::acos(d.high), std::acos(d.low), d.known, d.defined}, library_ulps);
  case Op::tanh:
  case Op::erf:
    return clipped(increasing(op, x), -1.0, 1.0);
  case Op::erfc: // falls
    return clipped(widened({std::erfc(x.high), std::erfc(x.low), x.known, x.defined}, special_ulps),
                   0.0, 2.0);
  case Op::atan:
  case Op::sinh:
    return increasing(op, x);
  default:
    return anything(x);
  }
}

Bounds special(Op op, std::span<const Bounds> args) {
  const Bounds& x = args.back();
  Bounds result;
  switch (op) {
  case Op::gamma:
    return gamma(x);
  case Op::polygamma:
    result = polygamma_bounds(args[0], x);
    break;
  case Op::erfcx:
    result = erfcx_bounds(args[0], x);
    break;
  case Op::mittag_leffler:
    result = mittag_leffler_bounds(args[0], args[1], x);
    break;
  default: { // |J_n| <= 1 for n >= 0 and for whole n
    const Bounds& n = args[0];
    const bool whole = is_point(n) && n.low == std::trunc(n.low);
    result = whole || n.low >= 0.0 ? Bounds{-1.0, 1.0, x.known, x.defined} : anything(x);
    if (!whole) result.defined = false;
  }
  }
  for (const Bounds& parameter : args.first(args.size() - 1)) {
    result.known = result.known && parameter.known;
    result.defined = result.defined && parameter.defined;
  }
  return result;
}

Bounds arctangent(const Bounds& y, const Bounds& x) {
  const bool cut = x.low <= 0.0 && y.low <= 0.0 && y.high >= 0.0; // may cross the jump at -pi, pi
  if (cut) return widened(with_flags(-pi, pi, y, x), 1);
  // Monotone in each variable elsewhere: the extremes are at corners.
  const std::array ends{std::atan2(y.low, x.low), std::atan2(y.low, x.high),
                        std::atan2(y.high, x.low), std::atan2(y.high, x.high)};
  const auto [low, high] = std::ranges::minmax(ends);
  return widened(with_flags(low, high, y, x), library_ulps);
}

Bounds tabulated(const Table& table, const Bounds& x, bool slope) {
  Bounds d = x;
  if (!cut_to_domain(d, table.first(), table.last())) return nowhere(x);
  const auto [low, high] = table.range(d.low, d.high, slope);
  // The interpolation formula is rounded a few times, relative to the values it mixes.
  const double rounding = 1e-14 * std::max(std::abs(low), std::abs(high));
  return {low - rounding, high + rounding, d.known, d.defined};
}

} // namespace hvi::solver::rules
