// What a kernel is: singularity, breaks, reach, finiteness; found symbolically where possible and
// checked at sample points.
#include "solver/history/traits.hpp"

#include "solver/history/breaks.hpp"
#include "solver/history/cancellation.hpp"
#include "solver/history/kernel_function.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>

namespace hvi::solver {

namespace {

double positive_horizon(double horizon) { return horizon > 0 ? horizon : 1.0; }

/// -d log|q| / d log lag between two lags.
double log_slope(const KernelFunction& q, double t, double small, double large) {
  const double a = std::abs(q(t, small)), b = std::abs(q(t, large));
  if (a == 0 || b == 0) return 0;
  return (std::log(a) - std::log(b)) / (std::log(large) - std::log(small));
}

/// e with q ~ lag^-e. Lags far below any step are allowed in (t, lag): the slope has settled at
/// 1e-60. A slope that still halves where the exponent of the lag doubles is a logarithm.
double singular_exponent(const KernelFunction& q, double horizon, double t0) {
  double exponent = 0;
  for (const double part : {1.0, 0.61, 0.23}) {
    const double t = t0 + part * horizon;
    double near = log_slope(q, t, 1e-140, 1e-120), far = log_slope(q, t, 1e-80, 1e-60);
    if (!std::isfinite(near) || !std::isfinite(far)) { // overflow: exponent above 2, or exp(1/lag)
      return std::numeric_limits<double>::infinity();
    }
    const bool logarithm = near < 0.03 && near < 0.75 * far;
    if (logarithm || near < 1e-9) continue;
    const double rounded = std::round(near * 1e6) / 1e6;
    exponent = std::max(exponent, std::abs(near - rounded) < 1e-9 ? rounded : near);
  }
  return exponent;
}

/// The least break beyond which all samples are exactly zero.
double reach(const KernelFunction& q, const std::vector<double>& breaks, double horizon,
             double t0) {
  const auto vanishes_beyond = [&](double lag) {
    for (int i = 1; i <= 400; ++i) {
      const double l = lag + (horizon - lag) * i / 400;
      for (const double t : {l, 0.5 * (l + horizon), horizon}) {
        if (q(t0 + t, l) != 0) return false;
      }
    }
    return true;
  };
  for (const double b : breaks) {
    if (b < horizon && vanishes_beyond(b)) return b;
  }
  return 0;
}

/// Breaks at lags that do not move with the time.
std::vector<double> fixed_breaks(const Breaks& breaks, double horizon, double t0) {
  const auto now = breaks.inside(t0 + horizon, 0, horizon),
             before = breaks.inside(t0 + 0.7 * horizon, 0, horizon);
  std::vector<double> fixed;
  for (const double b : now) {
    const bool stays = std::any_of(before.begin(), before.end(),
                                   [&](double a) { return std::abs(a - b) <= 1e-12 * horizon; });
    if (stays) fixed.push_back(b);
  }
  return fixed;
}

int count_rates(const ExponentialTerms& terms, bool complex) {
  std::vector<Complex> seen;
  for (const ExponentialTerm& term : terms) {
    if (term.lag_rate.imag() < 0 || (term.lag_rate.imag() != 0) != complex) continue;
    if (std::find(seen.begin(), seen.end(), term.lag_rate) == seen.end()) {
      seen.push_back(term.lag_rate);
    }
  }
  return static_cast<int>(seen.size());
}

std::string counted(int n, const char* what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

std::string describe(const KernelTraits& traits, const ExponentialTerms& terms) {
  if (traits.zero) return "zero";
  if (traits.exponential_sum || traits.separable) {
    const int real = count_rates(terms, false), pairs = count_rates(terms, true);
    std::string text;
    if (real > 0) text = counted(real, "real exponential");
    if (pairs > 0) text += (real > 0 ? ", " : "") + counted(pairs, "complex pair");
    return traits.separable ? "separable: " + text : text;
  }
  std::string text = traits.convolution ? "convolution" : "of t and s";
  if (traits.singular_exponent > 0) {
    text += fmt::format(", singular like lag^-{:.4g}", traits.singular_exponent);
  }
  if (!traits.breaks.empty()) {
    text += fmt::format(", {} at lag", counted(static_cast<int>(traits.breaks.size()), "break"));
    for (std::size_t i = 0; i < std::min<std::size_t>(3, traits.breaks.size()); ++i) {
      text += fmt::format(" {:.4g}", traits.breaks[i]);
    }
    if (traits.breaks.size() > 3) text += " ...";
  }
  if (traits.max_lag > 0) text += fmt::format(", zero beyond lag {:.4g}", traits.max_lag);
  return text;
}

/// (t, lag) at these parts of the horizon as t, with lags from T 1e-12 to t.
std::vector<std::pair<double, double>> points_at(double horizon,
                                                 std::initializer_list<double> parts) {
  std::vector<std::pair<double, double>> points;
  for (const double part : parts) {
    const double t = part * horizon;
    for (int i = 0; i <= 120; ++i) points.emplace_back(t, t * std::pow(10.0, -i / 10.0));
    for (int i = 1; i < 160; ++i) points.emplace_back(t, t * i / 160.0);
  }
  return points;
}

struct Sample {
  double t, lag, value, width; ///< width: the lags it stands for
};

/// A function of the lag alone needs fewer times.
std::vector<Sample> samples_of(const KernelFunction& q, double horizon, double t0) {
  std::vector<Sample> samples;
  for (const auto& [t, lag] :
       q.convolution() ? points_at(horizon, {1.0, 0.47}) : sample_points(horizon))
    samples.push_back({t0 + t, lag, q(t0 + t, lag), std::min(0.3 * lag, t / 80)});
  return samples;
}

/// The terms, if they are those of the kernel at the samples.
std::optional<VerifiedTerms> verified(std::optional<ExponentialTerms> terms,
                                      std::span<const Sample> samples) {
  if (!terms) return std::nullopt;
  double error = 0, integral = 0, sum = 0, largest = 0, now = samples.front().t;
  for (const auto& [t, lag, value, width] : samples) {
    const double off = std::abs(evaluate(*terms, t, lag) - value);
    if (t != now) sum = 0;
    now = t;
    sum += off * width;
    integral = std::max(integral, sum);
    largest = std::max(largest, std::abs(value));
    error = std::max(error, off);
    for (const ExponentialTerm& term : *terms) {
      if (term.of_time.is_constant() && term.of_source.is_constant()) continue;
      const auto value_of = [&, lag_ = lag, t_ = t](Slot s) {
        return s == slot::t ? t_ : t_ - lag_;
      };
      const double g = evaluate(term.of_time, value_of), h = evaluate(term.of_source, value_of);
      if (!(std::abs(g) < 1e100) || !(std::abs(h) < 1e100)) return std::nullopt;
    }
  }
  if (!std::isfinite(error) || error > 1e-12 * largest) return std::nullopt;
  return VerifiedTerms{std::move(*terms), error, integral};
}

} // namespace

std::vector<std::pair<double, double>> sample_points(double horizon) {
  return points_at(horizon, {1.0, 0.83, 0.47, 0.11, 0.013});
}

std::optional<VerifiedTerms> verified_terms(const Expr& expression, double horizon, double t0) {
  const KernelFunction q(expression, {});
  return verified(exponential_terms(expression), samples_of(q, positive_horizon(horizon), t0));
}

KernelTraits kernel_traits(const Expr& expression, double horizon, double t0) {
  return kernel_traits(KernelSpec{{}, {}, expression, {}}, horizon, t0);
}

KernelTraits kernel_traits(const KernelSpec& kernel, double horizon, double t0) {
  KernelSpec computed = kernel;
  computed.expression = without_cancellation(kernel.expression);
  return study_kernel(computed, horizon, t0).traits;
}

StudiedKernel study_kernel(const KernelSpec& kernel, double horizon, double t0) {
  const Expr& expression = kernel.expression;
  const double length = positive_horizon(horizon);
  const KernelFunction q(expression, {});
  const Breaks breaks(expression, {});
  StudiedKernel out;
  KernelTraits& traits = out.traits;
  traits.convolution = q.convolution();
  traits.zero = true;
  const auto samples = samples_of(q, length, t0);
  // A kernel of t and s may be infinite at the start of the run: its integral decides.
  const auto start_only = [&](const Sample& sample) {
    return expression.depends_on(slot::t) && sample.lag >= (sample.t - t0) * (1 - 1e-12) &&
           std::isfinite(q(sample.t, sample.lag * (1 - 1e-9)));
  };
  for (const Sample& sample : samples) {
    traits.finite = traits.finite && (std::isfinite(sample.value) || start_only(sample));
    traits.zero = traits.zero && sample.value == 0;
  }
  if (!breaks.empty()) traits.breaks = fixed_breaks(breaks, length, t0);
  traits.zero = traits.zero && expression.is(0); // a peak may lie between the samples
  if (!traits.breaks.empty()) traits.max_lag = reach(q, traits.breaks, length, t0);
  // A series that was written as one needs no recognition.
  out.terms = verified(
      kernel.series ? exponential_terms(*kernel.series) : exponential_terms(expression), samples);
  if (out.terms) {
    const auto& terms = out.terms->terms;
    const bool plain = std::all_of(terms.begin(), terms.end(), [](const ExponentialTerm& term) {
      return term.of_time.is_constant() && term.of_source.is_constant() && term.time_rate == 0.0;
    });
    (plain ? traits.exponential_sum : traits.separable) = true;
    traits.convolution = traits.convolution || plain; // exp(-t) exp(s) is one, too
  } else if (!traits.zero) {
    traits.singular_exponent = singular_exponent(q, length, t0);
  }
  traits.description = describe(traits, out.terms ? out.terms->terms : ExponentialTerms{});
  return out;
}

} // namespace hvi::solver
