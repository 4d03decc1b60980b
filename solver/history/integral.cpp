// Exact weights by quadrature in the lag variable, split at breaks and graded towards lag 0.
#include "solver/history/integral.hpp"

#include "solver/history/history.hpp"
#include "solver/history/quadrature.hpp"

#include <cmath>
#include <exception>
#include <limits>
#include <vector>

namespace hvi::solver {

struct KernelIntegral::Piece {
  double low, high, from, to;
  double x(double lag) const { return (lag - low) / (high - low); }
};

namespace {

Moments operator+(const Moments& a, const Moments& b) { return {a.zero + b.zero, a.one + b.one}; }

/// int_0^1 f by the double exponential rule: for integrands that are not smooth at 0. Not a number
/// where f is not (Boost throws; the caller says which kernel it was).
template <class F>
double integrate_singular(TanhSinh& rule, const F& f) {
  try {
    // The rule's own interval is (-1, 1); its second argument is the distance to the nearer end.
    const auto on_rule = [&](double x, double distance) {
      const double d = 0.5 * std::abs(distance);
      return 0.5 * f(x < 0 ? d : 1 - d);
    };
    return rule.integrate(on_rule, 1e-14);
  } catch (const std::exception&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

/// Does f go on below the first points of a panel on [0, to] as it does between them?
template <class F>
bool calm_below(const F& f, double to) {
  const double first = f(0.002 * to)[0], second = f(0.01 * to)[0];
  const double allowed =
      4 * std::abs(first - second) + 1e-12 * std::max(std::abs(first), std::abs(second));
  for (double v = 0.001 * to; v > 1e-18; v /= 2)
    if (!(std::abs(f(v)[0] - first) <= allowed)) return false;
  return true;
}

} // namespace

KernelIntegral::KernelIntegral(const KernelFunction& kernel, const Breaks& breaks,
                               double singular_exponent, Origin origin, std::string name)
    : kernel_(kernel), breaks_(breaks), exponent_(singular_exponent),
      rule_(std::make_shared<TanhSinh>(12)), origin_(origin), name_(std::move(name)) {}

Moments KernelIntegral::operator()(double t, double low, double high) const {
  if (!(high > low)) return {};
  std::vector<double> ends{low};
  if (!breaks_.empty()) {
    const auto inside = breaks_.inside(t, low, high);
    ends.insert(ends.end(), inside.begin(), inside.end());
  }
  ends.push_back(high);
  Moments sum;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const Piece piece{low, high, ends[i], ends[i + 1]};
    sum = sum + (piece.from == 0 ? at_zero(t, piece) : away(t, piece));
  }
  if (!std::isfinite(sum.zero) || !std::isfinite(sum.one)) {
    throw Failure(FailureKind::bad_kernel, origin_,
                  "the memory kernel `" + name_ +
                      "` has no finite integral, or changes too fast for one, over the lags " +
                      std::to_string(low) + " to " + std::to_string(high));
  }
  return sum;
}

/// With lag = h v^m, m = 1/(1 - e):  int_0^h q dlag = h^(1-e) m int_0^1 [q lag^e] dv. The bracket
/// is bounded, and a series in lag^(1-e) (fractional relaxation) becomes analytic in v.
Moments KernelIntegral::at_zero(double t, const Piece& piece) const {
  const double h = piece.to, e = exponent_, m = 1 / (1 - e);
  const auto bracket = [&](double v) -> Values<2> {
    // Below 1e-290 lag^e q is at its limit; smaller lags would underflow.
    const double lag = std::max(h * std::pow(v, m), 1e-290);
    const double q = e == 0 ? kernel_(t, lag) : kernel_(t, lag) * std::pow(lag, e);
    return {q, q * piece.x(lag)};
  };
  const double factor = std::pow(h, 1 - e) * m;
  Moments sum;
  double to = 1;
  // Panels that shrink fourfold towards 0, until one is smooth and hides nothing: a decay within
  // 1e-8 of the step falls between the points of a panel as long as the step.
  for (int level = 0; level < 20; ++level, to /= 4) {
    const auto panel = detail::gauss_kronrod_panel<2>(bracket, 0, to, {});
    if (panel.smooth && calm_below(bracket, to))
      return {factor * (sum.zero + panel.integral[0]), factor * (sum.one + panel.integral[1])};
    // What lies nearer to 0 is measured by what was found: there a kernel may be mere rounding.
    const auto values = integrate_smooth<2>(bracket, to / 4, to,
                                            {100 * std::abs(sum.zero), 100 * std::abs(sum.one)});
    sum = sum + Moments{values[0], values[1]};
  }
  const auto rest = [&](int i) {
    return to * integrate_singular(*rule_, [&](double v) { return bracket(to * v)[i]; });
  };
  return {factor * (sum.zero + rest(0)), factor * (sum.one + rest(1))};
}

/// Panels grow at most fourfold with the lag: a singularity at 0 stays at a fixed distance.
Moments KernelIntegral::away(double t, const Piece& piece) const {
  const auto f = [&](double lag) -> Values<2> {
    const double q = kernel_(t, lag);
    return {q, q * piece.x(lag)};
  };
  Moments sum;
  for (double from = piece.from; from < piece.to;) {
    const double to = piece.to <= 4 * from ? piece.to : 4 * from;
    const auto values = integrate_smooth<2>(f, from, to);
    sum = sum + Moments{values[0], values[1]};
    from = to;
  }
  return sum;
}

double interval_integral(const Expr& expression, double t, double lag_low, double lag_high,
                         int moment) {
  const KernelTraits traits = kernel_traits(expression, std::max(t, lag_high));
  const KernelIntegral integral(KernelFunction(expression, {}), Breaks(expression, {}),
                                traits.singular_exponent, {}, "q");
  const Moments m = integral(t, lag_low, lag_high);
  return moment == 0 ? m.zero : m.one;
}

} // namespace hvi::solver
