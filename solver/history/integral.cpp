// Exact weights by quadrature in the lag variable, split at breaks and graded towards lag 0.
#include "solver/history/integral.hpp"

#include "solver/history/cancellation.hpp"
#include "solver/history/history.hpp"
#include "solver/history/proved_quadrature.hpp"
#include "solver/history/traits.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <vector>

namespace hvi::solver {

struct KernelIntegral::Piece {
  double low, high, from, to;
  double x(double lag) const { return (lag - low) / (high - low); }
};

struct KernelIntegral::Tally {
  double scale = 0; ///< |q| at shorter lags times the length: rounding of it does not matter
  double size = 0, unresolved = 0, worst = 0, at = -1;
  template <std::size_t M>
  void add(const Proved<M>& part, double factor, double lag) {
    size += factor * part.size[0];
    unresolved += factor * part.unresolved;
    if (factor * part.unresolved > worst) worst = factor * part.unresolved, at = lag;
  }
};

namespace {

/// int_0^1 f for integrands that are not smooth at 0, by Boost's double exponential rule
/// (H. Takahasi, M. Mori, Double exponential formulas for numerical integration, Publ. RIMS Kyoto
/// Univ. 9 (1974) 721-741). Not a number where f is not (Boost throws; the caller names the
/// kernel).
template <class F>
double integrate_singular(TanhSinh& rule, const F& f) {
  try {
    // The rule's own interval is (-1, 1); its second argument is the distance to the nearer end.
    const auto on_rule = [&](double x, double distance) {
      const double d = 0.5 * std::abs(distance);
      return 0.5 * f(x < 0 ? d : 1 - d);
    };
    return rule.integrate(on_rule, 1e-14);
  } catch (const std::bad_alloc&) {
    throw;
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

/// A share of an integral beyond which a panel that could not be resolved is an error.
constexpr double unresolved_share = 1e-11;

/// Is f bounded around [0, to] so that the rule is exact to rounding?
template <class F>
bool is_small(const Modulus& m, const F& f, double to) {
  return m.state == Strip::State::analytic &&
         rule_error() * m.most <= 2e-15 * std::abs(f(0.5 * to)[0]);
}

/// Is f proved to have nothing narrow between `to` and the points that `calm_below` looks at?
/// Where no bound is known two rules must do.
template <class B, class F>
bool quiet(const B& modulus, const F& f, double to) {
  for (int i = 0; i < 10; ++i, to /= 2) {
    const Modulus m = modulus(to / 2, to);
    if (m.state == Strip::State::unknown) return true;
    if (m.state == Strip::State::singular) return false;
    const double here = std::max(std::abs(f(to)[0]), std::abs(f(0.5 * to)[0]));
    if (!(m.most <= 1e3 * here)) return false;
  }
  return true;
}

} // namespace

KernelIntegral::KernelIntegral(const Expr& expression, const KernelFunction& kernel,
                               const Breaks& breaks, double singular_exponent, Origin origin,
                               std::string name)
    : kernel_(kernel), breaks_(breaks), exponent_(singular_exponent),
      rule_(std::make_shared<TanhSinh>(12)), origin_(origin), name_(std::move(name)) {
  if (!breaks_.singular_at_source_zero()) return;
  const std::array<std::pair<Slot, Expr>, 1> change{
      {{slot::lag, Expr::variable(slot::t) - Expr::variable(slot::lag)}}};
  by_source_ = std::make_shared<KernelFunction>(substitute(expression, change), origin);
}

Moments KernelIntegral::operator()(double t, double low, double high) const {
  if (!(high > low)) return {};
  std::vector<double> ends{low};
  if (!breaks_.empty()) {
    const auto inside = breaks_.inside(t, low, high);
    ends.insert(ends.end(), inside.begin(), inside.end());
  }
  // The first interval of a memory that starts at 0: half of it as a function of s itself.
  const bool to_source_zero = by_source_ && t > 0 && std::abs(t - high) <= 4e-16 * t;
  if (to_source_zero && ends.back() < 0.5 * high) ends.push_back(0.5 * high);
  ends.push_back(high);
  Moments sum;
  Tally tally;
  for (int j = 0; j < 8; ++j) {
    const double q = std::abs(kernel_(t, std::ldexp(high, -j)));
    if (std::isfinite(q)) tally.scale = std::max(tally.scale, q * (high - low));
  }
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const Piece piece{low, high, ends[i], ends[i + 1]};
    if (to_source_zero && piece.to == high && piece.from > 0)
      sum = sum + from_source(t, piece, tally);
    else
      sum = sum + (piece.from == 0 ? at_zero(t, piece, tally) : away(t, piece, tally));
  }
  if (!(tally.unresolved <= unresolved_share * (tally.size + 0.01 * tally.scale) + 1e-280))
    refuse(t, low, high, tally.at);
  if (!std::isfinite(sum.zero) || !std::isfinite(sum.one)) refuse(t, low, high, -1);
  return sum;
}

/// `at`: the lag where it is worst, negative: not known.
void KernelIntegral::refuse(double t, double low, double high, double at) const {
  const std::string near =
      at < 0 ? "" : fmt::format("; look near lag {:.9g}, s = {:.9g}", at, t - at);
  throw Failure(FailureKind::bad_kernel, origin_,
                fmt::format("the memory kernel `{}` has no finite integral, or changes too fast "
                            "for one, over the lags {:.6g} to {:.6g} at t = {:.6g}{}",
                            name_, low, high, t, near),
                "a singularity must be integrable and stand at lag 0, or where an expression "
                "affine in t and s is zero");
}

/// With lag = h v^m, m = 1/(1 - e):  int_0^h q dlag = h^(1-e) m int_0^1 [q lag^e] dv. The bracket
/// is bounded, and a series in lag^(1-e) (fractional relaxation) becomes analytic in v.
Moments KernelIntegral::at_zero(double t, const Piece& piece, Tally& tally) const {
  const double h = piece.to, e = exponent_, m = 1 / (1 - e);
  const auto bracket = [&](double v) -> Values<2> {
    // Below 1e-290 lag^e q is at its limit; smaller lags would underflow.
    const double lag = std::max(h * std::pow(v, m), 1e-290);
    const double q = e == 0 ? kernel_(t, lag) : kernel_(t, lag) * std::pow(lag, e);
    return {q, q * piece.x(lag)};
  };
  const auto modulus = [&](double v_low, double v_high) -> Modulus {
    if (m != 1 && h * std::pow(v_high, m) < 1e-280) // where the bracket is at its limit
      return {std::abs(bracket(v_high)[0]), Strip::State::analytic};
    const Strip v = around(v_low, v_high);
    const Strip lags = scaled(h, m == 1 ? v : raised(v, m));
    if (lags.state != Strip::State::analytic) return {0, lags.state};
    Modulus q = kernel_.modulus(t, lags);
    if (e > 0) q.most *= std::pow(lags.modulus(), e);
    return q;
  };
  const double factor = std::pow(h, 1 - e) * m;
  Moments sum;
  double to = 1;
  // Panels that shrink fourfold towards 0, until one is smooth and hides nothing.
  for (int level = 0; level < 26; ++level, to /= 4) {
    const bool proved = is_small(modulus(0, to), bracket, to);
    const auto panel = detail::gauss_kronrod_panel<2>(bracket, 0, to, {});
    if (proved || (panel.smooth && calm_below(bracket, to) && quiet(modulus, bracket, to))) {
      tally.size += factor * panel.magnitude[0];
      return {factor * (sum.zero + panel.integral[0]), factor * (sum.one + panel.integral[1])};
    }
    // What lies nearer to 0 is measured by what was found: there a kernel may be mere rounding.
    auto values = integrate_proved<2>(bracket, modulus, to / 4, to,
                                      std::abs(sum.zero) + 0.01 * tally.scale / factor);
    if (!values.proved)
      values.integral = integrate_smooth<2>(bracket, to / 4, to,
                                            {100 * std::abs(sum.zero), 100 * std::abs(sum.one)});
    tally.add(values, factor, h * std::pow(values.at, m));
    sum = sum + Moments{values.integral[0], values.integral[1]};
  }
  const auto rest = [&](int i) {
    return to * integrate_singular(*rule_, [&](double v) { return bracket(to * v)[i]; });
  };
  return {factor * (sum.zero + rest(0)), factor * (sum.one + rest(1))};
}

Moments KernelIntegral::from_source(double t, const Piece& piece, Tally& tally) const {
  const double to = t - piece.from;
  const auto f = [&](double s) -> Values<2> {
    const double q = (*by_source_)(t, s);
    return {q, q * piece.x(t - s)};
  };
  const auto modulus = [&](double low, double high) {
    return by_source_->modulus(t, around(low, high));
  };
  const auto proved = integrate_proved<2>(f, modulus, 0.0, to, 0.01 * tally.scale);
  if (!proved.proved) {
    const auto values = integrate_graded<2>(f, 0.0, to);
    return {values[0], values[1]};
  }
  tally.add(proved, 1.0, t - proved.at);
  return {proved.integral[0], proved.integral[1]};
}

Moments KernelIntegral::away(double t, const Piece& piece, Tally& tally) const {
  const auto f = [&](double lag) -> Values<2> {
    const double q = kernel_(t, lag);
    return {q, q * piece.x(lag)};
  };
  const auto modulus = [&](double low, double high) {
    return kernel_.modulus(t, around(low, high));
  };
  const auto proved = integrate_proved<2>(f, modulus, piece.from, piece.to, 0.01 * tally.scale);
  if (!proved.proved) {
    const auto values = integrate_graded<2>(f, piece.from, piece.to);
    return {values[0], values[1]};
  }
  tally.add(proved, 1.0, proved.at);
  return {proved.integral[0], proved.integral[1]};
}

double interval_integral(const Expr& as_written, double t, double lag_low, double lag_high,
                         int moment) {
  const Expr expression = without_cancellation(as_written);
  const KernelTraits traits = kernel_traits(expression, lag_high, t - lag_high);
  const KernelIntegral integral(expression, KernelFunction(expression, {}), Breaks(expression, {}),
                                traits.singular_exponent, {}, "q");
  const Moments m = integral(t, lag_low, lag_high);
  return moment == 0 ? m.zero : m.one;
}

} // namespace hvi::solver
