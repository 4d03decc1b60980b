// Break lags: abs, min, max, comparisons and table points, followed to the lag where they switch.
#include "solver/history/breaks.hpp"

#include "solver/kernel/table.hpp"

#include <boost/math/tools/roots.hpp>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

AffineForm scaled(const AffineForm& a, double factor) {
  return {a.time * factor, a.lag * factor, a.constant * factor};
}

bool is_number(const AffineForm& a) { return a.time == 0 && a.lag == 0; }

std::optional<AffineForm> affine_product(const AffineForm& a, const AffineForm& b) {
  if (is_number(a)) return scaled(b, a.constant);
  if (is_number(b)) return scaled(a, b.constant);
  return std::nullopt;
}

} // namespace

std::optional<AffineForm> affine_form(const Expr& expression) {
  const auto arg = [&](std::size_t i) { return affine_form(expression.args()[i]); };
  switch (expression.op()) {
  case Op::constant:
    return AffineForm{0, 0, expression.value()};
  case Op::slot:
    if (expression.slot() == slot::t) return AffineForm{1, 0, 0};
    if (expression.slot() == slot::lag) return AffineForm{0, 1, 0};
    return std::nullopt;
  case Op::neg: {
    const auto a = arg(0);
    return a ? std::optional(scaled(*a, -1)) : std::nullopt;
  }
  case Op::add: {
    const auto a = arg(0), b = arg(1);
    if (!a || !b) return std::nullopt;
    return AffineForm{a->time + b->time, a->lag + b->lag, a->constant + b->constant};
  }
  case Op::mul: {
    const auto a = arg(0), b = arg(1);
    return a && b ? affine_product(*a, *b) : std::nullopt;
  }
  case Op::div: {
    const auto a = arg(0), b = arg(1);
    if (!a || !b || !is_number(*b)) return std::nullopt;
    return AffineForm{a->time / b->constant, a->lag / b->constant, a->constant / b->constant};
  }
  default:
    return std::nullopt;
  }
}

Breaks::Breaks(const Expr& expression, Origin origin) {
  collect(expression, origin);
  for (const Line& line : lines_) {
    if (line.per_time == 0) fixed_.push_back(line.at);
  }
  std::erase_if(lines_, [](const Line& line) { return line.per_time == 0; });
  std::sort(fixed_.begin(), fixed_.end());
  fixed_.erase(std::unique(fixed_.begin(), fixed_.end()), fixed_.end());
}

void Breaks::collect(const Expr& expression, Origin origin) {
  const auto args = expression.args();
  switch (expression.op()) {
  case Op::abs:
  case Op::sign:
    add_switch(args[0], origin);
    break;
  case Op::min:
  case Op::max:
  case Op::less:
  case Op::less_equal:
  case Op::equal:
    add_switch(args[0] - args[1], origin);
    break;
  case Op::table:
  case Op::table_slope:
    for (const double x : expression.table()->abscissae()) {
      add_switch(args[0] - Expr(x), origin);
    }
    break;
  case Op::sqrt:
  case Op::log:
    add_singularity(args[0]);
    break;
  case Op::div:
    add_singularity(args[1]);
    break;
  case Op::pow:
    if (!args[1].is_constant() || args[1].value() < 0 ||
        args[1].value() != std::round(args[1].value()))
      add_singularity(args[0]);
    break;
  default:
    break;
  }
  for (const Expr& a : args) collect(a, origin);
}

void Breaks::add_switch(const Expr& value, Origin origin) {
  if (!value.depends_on(slot::lag)) return; // switches in time only: no lag is special
  if (const auto a = affine_form(value)) {
    if (a->lag != 0) lines_.push_back({-a->time / a->lag, -a->constant / a->lag});
    return;
  }
  curves_.emplace_back(value, origin);
}

/// The zero of an affine base. For other bases the quadrature finds the place, or refuses the
/// kernel.
void Breaks::add_singularity(const Expr& value) {
  const auto a = affine_form(value);
  if (!a || a->lag == 0 || (a->time == 0 && a->constant == 0)) return; // lag 0 is always an end
  if (a->constant == 0 && a->time == -a->lag)
    source_zero_ = true;
  else
    lines_.push_back({-a->time / a->lag, -a->constant / a->lag});
}

/// Zeros by sign changes between samples, refined by Boost's implementation of G. E. Alefeld,
/// F. A. Potra, Y. Shi, Algorithm 748: enclosing zeros of continuous functions, ACM Trans. Math.
/// Softw. 21 (1995) 327-344.
void Breaks::add_roots(const KernelFunction& curve, double t, double low, double high,
                       std::vector<double>& found) {
  constexpr int samples = 16;
  for (int i = 0; i < samples; ++i) {
    const double a = low + (high - low) * i / samples, b = low + (high - low) * (i + 1) / samples;
    const double fa = curve(t, a), fb = curve(t, b);
    if (!(fa * fb < 0)) continue;
    std::uintmax_t limit = 100;
    const auto root =
        boost::math::tools::toms748_solve([&](double lag) { return curve(t, lag); }, a, b, fa, fb,
                                          boost::math::tools::eps_tolerance<double>(52), limit);
    found.push_back(0.5 * (root.first + root.second));
  }
}

std::vector<double> Breaks::inside(double t, double low, double high) const {
  // A break within rounding of an end splits off nothing.
  const double slack = 1e-14 * high;
  std::vector<double> found;
  auto first = std::upper_bound(fixed_.begin(), fixed_.end(), low + slack);
  for (; first != fixed_.end() && *first < high - slack; ++first) found.push_back(*first);
  for (const Line& line : lines_) {
    const double lag = line.per_time * t + line.at;
    if (lag > low + slack && lag < high - slack) found.push_back(lag);
  }
  // max(0, 1 - |lag - 1/2|): the kink of the inner function separates the zeros of the outer one.
  std::vector<double> ends = found;
  ends.push_back(low);
  ends.push_back(high);
  std::sort(ends.begin(), ends.end());
  for (const KernelFunction& curve : curves_) {
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
      add_roots(curve, t, ends[i], ends[i + 1], found);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

} // namespace hvi::solver
