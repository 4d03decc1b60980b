// Norms of a kernel for the hypotheses: sup |q|, the Lipschitz constant in t, int |q|.
#include "solver/common/numbers.hpp"
#include "solver/history/breaks.hpp"
#include "solver/history/cancellation.hpp"
#include "solver/history/history.hpp"
#include "solver/history/integral.hpp"
#include "solver/history/recognise.hpp"
#include "solver/history/traits.hpp"
#include "solver/kernel/algebra.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace hvi::solver {

namespace {

bool real_exponential(const ExponentialTerm& term) {
  return term.power == 0 && term.lag_rate.imag() == 0 && term.time_rate == 0.0 &&
         term.factor.imag() == 0 && term.of_time.is_constant() && term.of_source.is_constant();
}

/// c e^{-a lag} with a >= 0 has its largest value and slope at lag 0.
bool single_decaying(const ExponentialTerms& terms) {
  return terms.size() == 1 && real_exponential(terms[0]) && terms[0].lag_rate.real() <= 0;
}

/// Mean of |q| over the lags of a piece on which q changes its sign very often: there would be many
/// breaks, and a norm needs two or three digits. Multiples of the golden ratio modulo 1 as
/// sample points are in phase with no oscillation.
double sampled_mean(const KernelFunction& q, double t, double from, double to) {
  constexpr int samples = 4096;
  const double golden = (std::sqrt(5.0) - 1.0) / 2.0;
  double sum = 0.0, place = 0.5;
  for (int i = 0; i < samples; ++i) {
    sum += std::abs(q(t, from + (to - from) * place));
    place += golden - std::floor(place + golden);
  }
  return sum / samples;
}

/// Does q change its sign so often between these lags that a few samples see it all the time? Each
/// is somewhere in its part of the piece: evenly spaced ones meet an oscillation of nearly as many
/// periods to a part in phase.
bool oscillates_fast(const KernelFunction& q, double t, double from, double to) {
  constexpr int samples = 64, often = 16;
  int changes = 0;
  double last = 0.0;
  std::minstd_rand random(1);
  for (int i = 0; i < samples; ++i) {
    const double place = (i + static_cast<double>(random()) / std::minstd_rand::max()) / samples;
    const double value = q(t, from + (to - from) * place);
    changes += value * last < 0.0 ? 1 : 0;
    last = value;
  }
  return changes > often;
}

struct Crossings {
  std::optional<std::pair<double, double>> jump; ///< (t, s) where q(., s) jumps, or is a root
  double sup = 0, slope = 0;
};

/// q(s + lag, s) in slot::t = s: breaks in the lag are those that t meets at fixed s.
Expr at_fixed_source(const Expr& expression) {
  const std::array<std::pair<Slot, Expr>, 1> change{
      {{slot::t, Expr::variable(slot::t) + Expr::variable(slot::lag)}}};
  return substitute(expression, change);
}

/// At fixed s the time passes the breaks of the kernel in the lag and in t. A difference that does
/// not become smaller with the distance is a jump; a slope that grows without bound is a root. A
/// break at a fixed s is never passed.
Crossings look_across_breaks(const Expr& expression, const KernelFunction& q,
                             const KernelFunction& slope, double t0, double length) {
  const Breaks breaks(at_fixed_source(expression), {});
  Crossings out;
  if (breaks.empty()) return out;
  for (const double part : {0.003, 0.17, 0.47, 0.71, 0.93}) {
    const double s = t0 + part * length;
    for (const double lag : breaks.inside(s, 0, (1 - part) * length)) {
      const double t = s + lag;
      const auto across = [&](double d) { return std::abs(q(t + d, lag + d) - q(t - d, lag - d)); };
      const auto steepest = [&](double d) {
        return std::max(std::abs(slope(t + d, lag + d)), std::abs(slope(t - d, lag - d)));
      };
      const double far = 1e-4 * lag, near = 1e-9 * lag;
      const double size =
          std::max(std::abs(q(t + far, lag + far)), std::abs(q(t - far, lag - far)));
      out.sup = std::max(out.sup, std::max(size, std::abs(q(t, lag))));
      const bool jumps = across(near) > 0.3 * across(far) && across(near) > 1e-7 * size;
      const bool root = !(steepest(near) <= 1.5 * steepest(far) + 1e-6 * size / lag);
      if (jumps || root) out.jump = {t, s};
      out.slope = std::max(out.slope, steepest(far));
    }
  }
  return out;
}

} // namespace

std::optional<double> prony_integral(const ExponentialTerms& terms, double length) {
  double sum = 0.0;
  bool up = false, down = false;
  for (const ExponentialTerm& term : terms) {
    if (!real_exponential(term)) return std::nullopt;
    const double rate = term.lag_rate.real(),
                 factor = term.factor.real() * term.of_time.value() * term.of_source.value();
    (factor < 0.0 ? down : up) = true;
    sum += std::abs(factor) * (rate == 0.0 ? length : std::expm1(rate * length) / rate);
  }
  if (up && down) return std::nullopt;
  return sum;
}

/// |q| as an expression brings its own breaks where q changes sign.
double absolute_integral(const Expr& expression, double exponent, double t, double length) {
  if (length <= 0) return 0;
  const Expr magnitude = abs(expression);
  const KernelIntegral integral(magnitude, KernelFunction(magnitude, {}), Breaks(magnitude, {}),
                                exponent, {}, "q");
  const KernelFunction q(expression, {});
  // Pieces short enough that the search for sign changes sees every oscillation of moderate speed.
  constexpr int pieces = 64;
  double sum = 0;
  for (int i = 0; i < pieces; ++i) {
    const double from = length * i / pieces, to = length * (i + 1) / pieces;
    sum += oscillates_fast(q, t, from, to) ? (to - from) * sampled_mean(q, t, from, to)
                                           : integral(t, from, to).zero;
  }
  return sum;
}

double memory_norm(const Expr& expression, const KernelTraits& traits, double t0, double horizon) {
  double norm = 0;
  for (const double part : {0.1, 0.3, 0.6, 1.0}) {
    if (traits.convolution && part < 1) continue;
    norm = std::max(norm, absolute_integral(expression, traits.singular_exponent,
                                            t0 + part * horizon, part * horizon));
  }
  return norm;
}

KernelNorms kernel_norms(const Expr& as_written, double t0, double t1) {
  const double length = t1 - t0;
  const Expr expression = without_cancellation(as_written);
  if (const auto verified = verified_terms(expression, length, t0);
      verified && single_decaying(verified->terms)) {
    const double c = std::abs(verified->terms[0].factor), a = -verified->terms[0].lag_rate.real();
    return {c, c * a, *prony_integral(verified->terms, length), true};
  }
  const KernelTraits traits = kernel_traits(expression, length, t0);
  if (traits.singular_exponent >= 1) return {infinity, infinity, infinity, true};
  const KernelFunction q(expression, {});
  // At fixed s the lag grows with t: d/dt q(t, t - s) = q_t + q_lag.
  const KernelFunction slope(derivative(expression, slot::t) + derivative(expression, slot::lag),
                             {});
  KernelNorms norms;
  for (const auto& [t, lag] : sample_points(length)) {
    norms.sup = std::max(norms.sup, std::abs(q(t0 + t, lag)));
    norms.lipschitz = std::max(norms.lipschitz, std::abs(slope(t0 + t, lag)));
  }
  // An unbounded kernel has no norm at all; unbounded slopes grow without end as the lag shrinks.
  const auto unbounded = [&](const KernelFunction& f) {
    for (const double part : {0.11, 0.29, 0.53, 0.83, 1.0}) {
      const double t = t0 + part * length;
      const double small = std::abs(f(t, length * 1e-100)), large = std::abs(f(t, length * 1e-50));
      if (!std::isfinite(small) || small > 1.5 * large + 1e-300) return true;
    }
    return false;
  };
  const Crossings crossings = look_across_breaks(expression, q, slope, t0, length);
  norms.sup = std::max(norms.sup, crossings.sup);
  norms.lipschitz = crossings.jump ? infinity : std::max(norms.lipschitz, crossings.slope);
  if (unbounded(q)) norms.sup = infinity;
  if (unbounded(slope)) norms.lipschitz = infinity;
  const std::vector<double> parts = traits.convolution
                                        ? std::vector<double>{1.0}
                                        : std::vector<double>{0.05, 0.2, 0.4, 0.6, 0.8, 1.0};
  for (const double part : parts) {
    norms.l1 = std::max(norms.l1, absolute_integral(expression, traits.singular_exponent,
                                                    t0 + part * length, part * length));
  }
  return norms;
}

} // namespace hvi::solver
