// Growth of expressions on a ray (tail.hpp).
#include "solver/kernel/tail.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/interval_rules.hpp"
#include "solver/kernel/node.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace hvi::solver {

namespace {

using namespace rules;

constexpr double exponential = 40.0; ///< the power that stands for faster than every power

Bounds point(double v) { return {v, v}; }
Tail unknown() { return {{-infinity, infinity, false, true}, 0.0, 0.0}; }

/// from^power (ln from)^log_power.
Bounds factor_at(double from, double power, double log_power) {
  const Bounds r = rules::power(point(from), point(power));
  return multiply(r, rules::power(function(Op::log, point(from)), point(log_power)));
}

/// Range of r^power (ln r)^log_power over r >= from; nothing is known where it is not monotone.
Bounds factor_range(double from, double power, double log_power) {
  if (power == 0.0 && log_power == 0.0) return point(1.0);
  const bool dies = power < 0.0 || (power == 0.0 && log_power < 0.0);
  const double turn = power == 0.0 ? 0.0 : -log_power / power; // ln r of the extreme
  if (std::log(from) < turn + 1e-9) return {0.0, infinity};
  const Bounds start = factor_at(from, power, log_power);
  return dies ? Bounds{0.0, start.high} : Bounds{start.low, infinity};
}

class TailWalk {
public:
  TailWalk(const Ray& ray, const std::function<Bounds(Slot)>& box) : ray_(ray), box_(box) {}

  Tail operator()(const Expr& e) {
    postorder(e, [&](const Expr& node) {
      Tail found = of(node);
      if (std::isnan(found.coefficient.low) || std::isnan(found.coefficient.high))
        found = unknown();
      done_.emplace(node.id(), found);
    });
    return done_.at(e.id());
  }

private:
  const Tail& arg(const Expr& e, std::size_t i) const { return done_.at(e.args()[i].id()); }

  Tail of(const Expr& e) const {
    if (e.is_constant()) return {point(e.value())};
    switch (e.op()) {
    case Op::slot:
      return e.slot() == ray_.slot ? Tail{point(ray_.sign), 1.0} : Tail{box_(e.slot())};
    case Op::add:
      return e.args()[0].is(1.0) || e.args()[1].is(1.0) ? one_plus(e) : sum(arg(e, 0), arg(e, 1));
    case Op::neg:
      return {negate(arg(e, 0).coefficient), arg(e, 0).power, arg(e, 0).log_power};
    case Op::mul:
      return product(arg(e, 0), arg(e, 1));
    case Op::div:
      return product(arg(e, 0), raised(arg(e, 1), -1.0));
    case Op::sqrt:
      return raised(arg(e, 0), 0.5);
    case Op::pow:
      if (e.args()[1].is_constant()) return raised(arg(e, 0), e.args()[1].value());
      return by_ranges(e);
    case Op::abs:
      return {function(Op::abs, arg(e, 0).coefficient), arg(e, 0).power, arg(e, 0).log_power};
    case Op::exp:
      return exponential_of(arg(e, 0));
    case Op::log:
      return logarithm_of(arg(e, 0));
    case Op::sinh:
    case Op::cosh:
      return hyperbolic(e.op(), arg(e, 0));
    case Op::erfc:
      return error_left(arg(e, 0), e);
    case Op::erfcx:
      return scaled_error(e);
    case Op::min:
    case Op::max:
    case Op::less:
    case Op::less_equal:
      return compared(e);
    case Op::select:
      return chosen(e);
    default:
      return by_ranges(e);
    }
  }

  Tail by_ranges(const Expr& e) const {
    std::array<Bounds, 3> ranges;
    const std::size_t n = e.args().size();
    for (std::size_t i = 0; i < n; ++i) ranges[i] = range_of(arg(e, i), ray_);
    return {extension(e, std::span(ranges).first(n))};
  }

  /// Brings two tails to the larger one's powers.
  std::pair<Tail, Tail> aligned(const Tail& a, const Tail& b) const {
    if (std::pair(a.power, a.log_power) < std::pair(b.power, b.log_power)) {
      const auto [x, y] = aligned(b, a);
      return {y, x};
    }
    const Bounds part = factor_range(ray_.from, b.power - a.power, b.log_power - a.log_power);
    return {a, {multiply(b.coefficient, part), a.power, a.log_power}};
  }

  Tail sum(const Tail& a, const Tail& b) const {
    const auto [x, y] = aligned(a, b);
    return {add(x.coefficient, y.coefficient), x.power, x.log_power};
  }

  /// 1 - tanh(z)^2, the derivative of tanh, is 1 / cosh(z)^2: it dies exponentially.
  Tail one_plus(const Expr& e) const {
    const Expr& other = e.args()[e.args()[0].is(1.0) ? 1 : 0];
    if (other.op() == Op::neg && other.args()[0].op() == Op::pow &&
        other.args()[0].args()[1].is(2.0) && other.args()[0].args()[0].op() == Op::tanh) {
      const Tail& z = done_.at(other.args()[0].args()[0].args()[0].id());
      return raised(hyperbolic(Op::cosh, z), -2.0);
    }
    return sum(arg(e, 0), arg(e, 1));
  }

  static Tail product(const Tail& a, const Tail& b) {
    return {multiply(a.coefficient, b.coefficient), a.power + b.power, a.log_power + b.log_power};
  }

  static Tail raised(const Tail& a, double exponent) {
    if (exponent == -1.0) return {divide(point(1.0), a.coefficient), -a.power, -a.log_power};
    return {rules::power(a.coefficient, point(exponent)), a.power * exponent,
            a.log_power * exponent};
  }

  /// exp(a r^p ...) against r^40 or r^-40, from where that comparison is monotone.
  Tail exponential_of(const Tail& z) const {
    const Bounds& a = z.coefficient;
    if (!z.grows()) return {function(Op::exp, range_of(z, ray_))};
    const bool rises = a.low > 0.0, dies = a.high < 0.0;
    const double size = rises ? a.low : -a.high;
    if (!(rises || dies) || z.power <= 0.0 || z.log_power < 0.0)
      return {function(Op::exp, range_of(z, ray_))};
    if (!(size * z.power * std::pow(ray_.from, z.power) > 2.0 * exponential))
      return {function(Op::exp, range_of(z, ray_))};
    const Bounds at = multiply(point(size), factor_at(ray_.from, z.power, 0.0));
    const Bounds against = multiply(point(exponential), function(Op::log, point(ray_.from)));
    const Bounds ratio = function(Op::exp, add(at, negate(against))); // exp(size r^p) / r^40
    if (rises) return {{ratio.low, infinity, a.known, a.defined}, exponential};
    return {{0.0, divide(point(1.0), ratio).high, a.known, a.defined}, -exponential};
  }

  /// ln(a r^p (ln r)^q) = ln r (p + (ln a + q ln ln r) / ln r).
  Tail logarithm_of(const Tail& z) const {
    if (!(z.coefficient.low > 0.0) || !std::isfinite(z.coefficient.high) || std::log(ray_.from) < 3)
      return {function(Op::log, range_of(z, ray_))};
    const Bounds of_a = function(Op::log, z.coefficient);
    if (z.power == 0.0 && z.log_power == 0.0) return {of_a};
    const Bounds ln = function(Op::log, point(ray_.from));
    const Bounds inverse{0.0, divide(point(1.0), ln).high};         // 1 / ln r
    const Bounds slow{0.0, divide(function(Op::log, ln), ln).high}; // ln ln r / ln r, falling
    const Bounds inside =
        add(point(z.power), add(multiply(of_a, inverse), multiply(point(z.log_power), slow)));
    return {inside, 0.0, 1.0};
  }

  Tail hyperbolic(Op op, const Tail& z) const {
    const Tail up = exponential_of(z);
    const Tail down = exponential_of({negate(z.coefficient), z.power, z.log_power});
    const Tail both =
        sum(up, op == Op::cosh ? down : Tail{negate(down.coefficient), down.power, down.log_power});
    return {multiply(both.coefficient, point(0.5)), both.power, both.log_power};
  }

  /// erfc(z) <= exp(-z^2) for z >= 0.
  Tail error_left(const Tail& z, const Expr& e) const {
    const Tail square = raised(z, 2.0);
    if (!z.grows() || !(z.coefficient.low > 0.0)) return by_ranges(e);
    return product({{0.0, 1.0}},
                   exponential_of({negate(square.coefficient), square.power, square.log_power}));
  }

  /// z^(n+1) w_n(z) rises to 1 / (2^n sqrt(pi)): in the integral of w_n (erfcx.cpp) u = s z leaves
  /// exp(-u^2 / z^2) alone to depend on z.
  Tail scaled_error(const Expr& e) const {
    const Tail& z = arg(e, 1);
    const Expr& order = e.args()[0];
    if (!order.is_constant() || !z.grows()) return by_ranges(e);
    if (range_of(z, ray_).high <= -1.0) return scaled_error_left(z, order.value());
    if (!(z.coefficient.low > 0.0)) return by_ranges(e);
    const double n = order.value(), first = range_of(z, ray_).low;
    const Bounds start = multiply(rules::power(point(first), point(n + 1.0)),
                                  extension(e, std::array{point(n), point(first)}));
    const double limit = std::numbers::inv_sqrtpi * std::exp2(-n) * (1.0 + 1e-15);
    if (!std::isfinite(start.low) || !(start.low <= limit)) return by_ranges(e);
    return product({{start.low, limit, z.coefficient.known, z.coefficient.defined}},
                   raised(z, -(n + 1.0)));
  }

  /// w_n(-y) = exp(y^2) 2 / (sqrt(pi) n!) int_0^oo s^n exp(-(s - y)^2) ds >= exp(y^2) y^n / n!, by
  /// what is beyond s = y.
  Tail scaled_error_left(const Tail& z, double n) const {
    const Tail grows = exponential_of(raised(z, 2.0));
    const double low = (1.0 - 1e-12) / std::tgamma(n + 1.0);
    return product({{low, infinity, z.coefficient.known, z.coefficient.defined}}, grows);
  }

  Tail compared(const Expr& e) const {
    const auto [x, y] = aligned(arg(e, 0), arg(e, 1));
    const std::array both{x.coefficient, y.coefficient};
    const Bounds found = extension(e, both);
    if (e.op() == Op::min || e.op() == Op::max) return {found, x.power, x.log_power};
    return {found};
  }

  Tail chosen(const Expr& e) const {
    const Bounds condition = range_of(arg(e, 0), ray_);
    if (condition.low > 0.0 || condition.high < 0.0) return arg(e, 1);
    if (condition.low == 0.0 && condition.high == 0.0) return arg(e, 2);
    const auto [x, y] = aligned(arg(e, 1), arg(e, 2));
    return {hull(x.coefficient, y.coefficient), x.power, x.log_power};
  }

  const Ray& ray_;
  const std::function<Bounds(Slot)>& box_;
  NodeMap<Tail> done_;
};

} // namespace

Tail tail_of(const Expr& e, const Ray& ray, const std::function<Bounds(Slot)>& box) {
  return TailWalk(ray, box)(e);
}

Bounds range_of(const Tail& tail, const Ray& ray) {
  return multiply(tail.coefficient, factor_range(ray.from, tail.power, tail.log_power));
}

} // namespace hvi::solver
