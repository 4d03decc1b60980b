// The search for a short sum of exponentials: a fit with all candidate poles; elimination of poles
// as long as the tolerance holds; elimination with refinement of the remaining poles; verification.
#include "solver/history/pole_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace hvi::solver {

namespace {

constexpr std::size_t max_points = 6000;

std::vector<Pole> without(const std::vector<Pole>& poles, std::size_t index) {
  std::vector<Pole> rest = poles;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(index));
  return rest;
}

/// Poles in the order of what their removal costs per field.
std::vector<std::size_t> cheapest(const PoleFit::Solution& s) {
  std::vector<std::size_t> order(s.poles.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return s.loss[a] * static_cast<double>(s.poles[b].fields()) <
           s.loss[b] * static_cast<double>(s.poles[a].fields());
  });
  return order;
}

/// As many poles as together should cost less than a tenth of what may still be lost, at least one.
std::vector<Pole> without_cheapest(const PoleFit::Solution& s, double target, bool several) {
  std::vector<bool> dropped(s.poles.size(), false);
  double cost = 0;
  std::size_t count = 0;
  for (const std::size_t i : cheapest(s)) {
    cost += s.loss[i];
    if (count > 0 && (!several || cost > 0.1 * target * target)) break;
    if (++count == s.poles.size()) break;
    dropped[i] = true;
  }
  std::vector<Pole> rest;
  for (std::size_t i = 0; i < s.poles.size(); ++i) {
    if (!dropped[i]) rest.push_back(s.poles[i]);
  }
  return rest;
}

/// Drops poles while the coefficients alone make up for them: several at once, then one by one.
PoleFit::Solution eliminate(const PoleFit& fit, PoleFit::Solution s, double target) {
  for (const bool several : {true, false}) {
    while (s.poles.size() > 1) {
      const auto next = fit.solve(without_cheapest(s, target, several));
      if (next.residual > target) break;
      s = next;
    }
  }
  return s;
}

/// Drops poles while the others can be moved to make up for them.
PoleFit::Solution eliminate_and_refine(const PoleFit& fit, PoleFit::Solution s, double target) {
  constexpr std::size_t tries = 2;
  for (bool smaller = true; smaller && s.poles.size() > 1;) {
    smaller = false;
    const auto order = cheapest(s);
    for (std::size_t i = 0; i < std::min(tries, order.size()) && !smaller; ++i) {
      const auto next = fit.refine(fit.solve(without(s.poles, order[i])), target, 25);
      if (next.residual > target) continue;
      s = next;
      smaller = true;
    }
  }
  return s;
}

/// All candidates: a real dictionary if that is enough, a denser one, then oscillations as well.
PoleFit::Solution first_solution(const PreparedKernel& kernel, const KernelSamples& samples,
                                 const PoleFit& fit, double target) {
  for (const double per_decade : {5.0, 8.0}) {
    auto solution = fit.solve(real_candidates(samples, per_decade));
    if (solution.residual <= target) return solution;
  }
  auto candidates = oscillating_candidates(kernel, samples);
  const auto real = real_candidates(samples, 5.0);
  candidates.insert(candidates.end(), real.begin(), real.end());
  return fit.refine(fit.solve(candidates), target, 40);
}

/// The kernel as the short sum that it may be, if it is one.
std::optional<PoleFit::Solution> short_sum(const PreparedKernel& kernel,
                                           const KernelSamples& samples, const PoleFit& fit,
                                           double target) {
  const auto poles = window_candidates(kernel, samples);
  if (poles.empty()) return std::nullopt;
  auto solution = fit.refine(fit.solve(poles), target, 10);
  if (solution.residual > target) return std::nullopt;
  return eliminate(fit, solution, target);
}

FitOutcome failed(std::string why) { return {std::nullopt, std::move(why)}; }

} // namespace

double fit_error(const PreparedKernel& kernel, const ExponentialTerms& terms, double low,
                 double high) {
  const auto samples = sample_kernel(kernel, low, high, 1e-6, 20 * max_points);
  if (!samples) return std::numeric_limits<double>::infinity();
  // Three points in every gap between sample points: none of them was seen by the fit.
  double error = 0;
  double previous = low;
  std::vector<double> lags = samples->lag;
  std::sort(lags.begin(), lags.end());
  lags.push_back(high);
  for (const double lag : lags) {
    for (const double part : {1.0 / 6, 0.5, 5.0 / 6}) {
      const double at = previous + part * (lag - previous);
      error += (lag - previous) / 3 * std::abs(evaluate(terms, 0.0, at) - kernel.function(0.0, at));
    }
    previous = lag;
  }
  return error / samples->norm;
}

FitOutcome fit_exponentials(const PreparedKernel& kernel, double low, double high,
                            double tolerance) {
  // Enough points for the least squares; whether the fit holds between them is verified at the end.
  const auto samples = sample_kernel(kernel, low, high, std::max(tolerance, 1e-3), max_points);
  if (!samples) return failed("it has kinks or oscillates too fast over the whole time");
  // Coefficients are stored in double precision: cancellation must stay below the tolerance.
  const double cap = std::min(1e4, 1e13 * tolerance);
  const PoleFit fit(*samples, tolerance, cap);
  const double target = 0.5 * tolerance;
  const auto few = short_sum(kernel, *samples, fit, target);
  auto solution = few ? *few : first_solution(kernel, *samples, fit, target);
  if (solution.residual > target) {
    return failed(fmt::format("the best sum of exponentials found has error {:.1e} of its norm",
                              solution.residual));
  }
  solution = eliminate_and_refine(fit, eliminate(fit, solution, target), target);
  FittedSum sum{fit.terms(solution), fields_of(solution.poles), 0};
  sum.error = fit_error(kernel, sum.terms, low, high);
  if (!(sum.error <= tolerance)) {
    return failed(fmt::format("the fitted sum of exponentials failed its verification "
                              "(error {:.1e} of the norm)",
                              sum.error));
  }
  return {std::move(sum), {}};
}

} // namespace hvi::solver
