// Interval arithmetic and the walk over an expression (interval.hpp).
#include "solver/kernel/interval.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/interval_rules.hpp"
#include "solver/kernel/node.hpp"
#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace hvi::solver {

namespace rules {

namespace {

/// 0 * inf is 0 here: the infinite end is a bound, not a value.
double end_product(double a, double b) { return (a == 0.0 || b == 0.0) ? 0.0 : a * b; }

/// Rounding outwards leaves the sign that the factors give: next to infinity, where exp overflows,
/// one unit on the other side of 0 would become an infinite end.
Bounds on_side(Bounds b, bool not_negative, bool not_positive) {
  if (not_negative) b.low = std::max(b.low, 0.0);
  if (not_positive) b.high = std::min(b.high, 0.0);
  return b;
}

/// 1/b for b on one side of 0, which may be an end.
Bounds reciprocal(const Bounds& b) {
  const bool touches = b.low <= 0.0 && b.high >= 0.0;
  const double low = b.high == 0.0 ? -infinity : 1.0 / b.high;
  const double high = b.low == 0.0 ? infinity : 1.0 / b.low;
  return on_side(widened({low, high, b.known, b.defined && !touches}, 1), b.low >= 0.0,
                 b.high <= 0.0);
}

Bounds whole_power(const Bounds& b, int n) {
  if (n < 0) return divide({1.0, 1.0}, whole_power(b, -n));
  // Repeated multiplication rounds at most 2 log2(n) times.
  const int ulps = 2 * n + 1;
  const double at_low = integer_power(b.low, n), at_high = integer_power(b.high, n);
  if (n % 2 == 1) return widened({at_low, at_high, b.known, b.defined}, ulps);
  const double top = std::max(at_low, at_high);
  const double bottom = b.contains(0.0) ? 0.0 : std::min(at_low, at_high);
  Bounds result = widened({bottom, top, b.known, b.defined}, ulps);
  result.low = std::max(result.low, 0.0);
  return result;
}

/// x^p on x >= 0 for a fixed p that is not whole.
Bounds real_power(const Bounds& b, double p) {
  if (b.high < 0.0) return {-infinity, infinity, b.known, false};
  const double at_low = std::pow(std::max(b.low, 0.0), p), at_high = std::pow(b.high, p);
  const bool defined = b.defined && b.low >= 0.0 && (p > 0.0 || b.low > 0.0);
  Bounds result{std::min(at_low, at_high), std::max(at_low, at_high), b.known, defined};
  result = widened(result, library_ulps);
  result.low = std::max(result.low, 0.0);
  return result;
}

} // namespace

Bounds with_flags(double low, double high, const Bounds& a, const Bounds& b) {
  return {low, high, a.known && b.known, a.defined && b.defined};
}

Bounds widened(Bounds b, int ulps) {
  // |v| 2^-52 is at least one unit in the last place of v, next to 0 the least number is.
  constexpr double most = std::numeric_limits<double>::max();
  constexpr double least = std::numeric_limits<double>::denorm_min();
  const auto step = [&](double v) { return ulps * (std::abs(v) * 0x1p-52 + least); };
  b.low = b.low == infinity ? most : b.low - step(b.low);
  b.high = b.high == -infinity ? -most : b.high + step(b.high);
  return b;
}

Bounds anything(const Bounds& from) { return {-infinity, infinity, false, from.defined}; }

Bounds hull(const Bounds& a, const Bounds& b) {
  return with_flags(std::min(a.low, b.low), std::max(a.high, b.high), a, b);
}

Bounds add(const Bounds& a, const Bounds& b) {
  const double low = a.low + b.low, high = a.high + b.high; // NaN: opposite infinities
  return widened(
      with_flags(std::isnan(low) ? -infinity : low, std::isnan(high) ? infinity : high, a, b), 1);
}

Bounds negate(const Bounds& a) { return {-a.high, -a.low, a.known, a.defined}; }

Bounds multiply(const Bounds& a, const Bounds& b) {
  const std::array ends{end_product(a.low, b.low), end_product(a.low, b.high),
                        end_product(a.high, b.low), end_product(a.high, b.high)};
  const auto [low, high] = std::ranges::minmax(ends);
  Bounds result = with_flags(low, high, a, b);
  const bool up_a = a.low >= 0.0, down_a = a.high <= 0.0, up_b = b.low >= 0.0,
             down_b = b.high <= 0.0;
  // a product of two values that underflows is no exact 0
  if ((up_a && down_a) || (up_b && down_b)) return result;
  return on_side(widened(result, 1), (up_a && up_b) || (down_a && down_b),
                 (up_a && down_b) || (down_a && up_b));
}

Bounds divide(const Bounds& a, const Bounds& b) {
  if (b.low < 0.0 && b.high > 0.0) return {-infinity, infinity, a.known && b.known, false};
  if (b.low == 0.0 && b.high == 0.0) return {-infinity, infinity, a.known && b.known, false};
  return multiply(a, reciprocal(b));
}

Bounds power(const Bounds& base, const Bounds& exponent) {
  if (is_point(exponent) && is_multiplied_power(exponent.low)) {
    Bounds result = whole_power(base, static_cast<int>(exponent.low));
    result.known = result.known && exponent.known;
    return result;
  }
  if (is_point(exponent)) return real_power(base, exponent.low);
  if (base.low <= 0.0) return {-infinity, infinity, base.known && exponent.known, false};
  return widened(function(Op::exp, multiply(exponent, function(Op::log, base))), library_ulps);
}

} // namespace rules

namespace {

/// Truth of a comparison or of logic as an interval in [0, 1].
Bounds truth(bool surely, bool surely_not, const Bounds& a, const Bounds& b) {
  return rules::with_flags(surely ? 1.0 : 0.0, surely_not ? 0.0 : 1.0, a, b);
}

bool is_true(const Bounds& b) { return b.low > 0.0 || b.high < 0.0; }
bool is_false(const Bounds& b) { return b.low == 0.0 && b.high == 0.0; }

Bounds logic(Op op, const Bounds& a, const Bounds& b) {
  switch (op) {
  case Op::less:
    return truth(a.high < b.low, a.low >= b.high, a, b);
  case Op::less_equal:
    return truth(a.high <= b.low, a.low > b.high, a, b);
  case Op::equal:
    return truth(rules::is_point(a) && rules::is_point(b) && a.low == b.low,
                 a.high < b.low || b.high < a.low, a, b);
  case Op::logic_and:
    return truth(is_true(a) && is_true(b), is_false(a) || is_false(b), a, b);
  case Op::logic_or:
    return truth(is_true(a) || is_true(b), is_false(a) && is_false(b), a, b);
  default:
    return truth(is_false(a), is_true(a), a, a); // not
  }
}

Bounds chosen(const Bounds& condition, const Bounds& then, const Bounds& otherwise) {
  Bounds result = is_true(condition)    ? then
                  : is_false(condition) ? otherwise
                                        : rules::hull(then, otherwise);
  result.known = result.known && condition.known;
  result.defined = result.defined && condition.defined;
  return result;
}

} // namespace

Bounds rules::extension(const Expr& e, std::span<const Bounds> a) {
  switch (e.op()) {
  case Op::add:
    return add(a[0], a[1]);
  case Op::neg:
    return negate(a[0]);
  case Op::mul:
    return multiply(a[0], a[1]);
  case Op::div:
    return divide(a[0], a[1]);
  case Op::pow:
    return power(a[0], a[1]);
  case Op::min:
    return with_flags(std::min(a[0].low, a[1].low), std::min(a[0].high, a[1].high), a[0], a[1]);
  case Op::max:
    return with_flags(std::max(a[0].low, a[1].low), std::max(a[0].high, a[1].high), a[0], a[1]);
  case Op::atan2:
    return arctangent(a[0], a[1]);
  case Op::less:
  case Op::less_equal:
  case Op::equal:
  case Op::logic_and:
  case Op::logic_or:
    return logic(e.op(), a[0], a[1]);
  case Op::logic_not:
    return logic(e.op(), a[0], a[0]);
  case Op::select:
    return chosen(a[0], a[1], a[2]);
  case Op::table:
  case Op::table_slope:
    return tabulated(*e.table(), a[0], e.op() == Op::table_slope);
  case Op::gamma:
  case Op::bessel_j:
  case Op::erfcx:
  case Op::mittag_leffler:
  case Op::polygamma:
    return special(e.op(), a);
  default:
    return function(e.op(), a[0]);
  }
}

namespace {

/// May the operation jump inside its arguments' ranges? `result` is its enclosure.
bool may_jump(const Expr& e, const Bounds& result) {
  switch (e.op()) {
  case Op::less:
  case Op::less_equal:
  case Op::equal:
  case Op::sign:
  case Op::table_slope: // where it is continuous it has no derivative as an expression
    return !rules::is_point(result);
  case Op::atan2: // across its cut
    return result.low <= -std::numbers::pi || result.high >= std::numbers::pi;
  default:
    return false;
  }
}

} // namespace

IntervalTape::IntervalTape(std::span<const Expr> outputs) {
  NodeMap<int> place;
  const auto add = [&](const Expr& node) {
    Step step{node, {}, -1};
    for (std::size_t i = 0; i < std::min<std::size_t>(3, node.args().size()); ++i)
      step.args[i] = place.at(node.args()[i].id());
    if (node.op() == Op::slot) {
      const auto known = std::find(inputs_.begin(), inputs_.end(), node.slot());
      step.input = static_cast<int>(known - inputs_.begin());
      if (known == inputs_.end()) inputs_.push_back(node.slot());
    }
    place.emplace(node.id(), static_cast<int>(steps_.size()));
    steps_.push_back(std::move(step));
  };
  for (const Expr& e : outputs) {
    postorder(
        e, [&](const Expr& node) { return place.count(node.id()) == 0; }, add);
    outputs_.push_back(place.at(e.id()));
    if (outputs_.size() == 1) of_first_ = static_cast<int>(steps_.size());
  }
}

bool IntervalTape::operator()(std::span<const Bounds> box, std::span<Bounds> out,
                              std::vector<Bounds>& work) const {
  work.resize(steps_.size());
  bool continuous = true;
  const int last = *std::max_element(outputs_.begin(),
                                     outputs_.begin() + static_cast<std::ptrdiff_t>(out.size()));
  for (int i = 0; i <= last; ++i) {
    const Step& step = steps_[i];
    Bounds& found = work[i];
    if (step.node.is_constant()) {
      found = {step.node.value(), step.node.value()};
    } else if (step.input >= 0) {
      found = box[step.input];
    } else {
      std::array<Bounds, 3> args;
      const std::size_t n = std::min<std::size_t>(3, step.node.args().size());
      for (std::size_t k = 0; k < n; ++k) args[k] = work[step.args[k]];
      found = rules::extension(step.node, std::span(args).first(n));
      if (i < of_first_ && may_jump(step.node, found)) continuous = false;
    }
    if (std::isnan(found.low) || std::isnan(found.high))
      found = {-HUGE_VAL, HUGE_VAL, false, false};
  }
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = work[outputs_[k]];
  return continuous;
}

Bounds bounds(const Expr& e, const std::function<Bounds(Slot)>& box) {
  const IntervalTape tape({&e, 1});
  std::vector<Bounds> inputs, work;
  for (const Slot s : tape.inputs()) inputs.push_back(box(s));
  Bounds out;
  tape(inputs, {&out, 1}, work);
  return out;
}

} // namespace hvi::solver
