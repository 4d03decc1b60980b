// Weights of many intervals at once.
#include "solver/history/past_weights.hpp"

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <cmath>

namespace hvi::solver {

namespace {

using Rule = boost::math::quadrature::gauss_kronrod<double, 15>;
using Gauss = boost::math::quadrature::gauss<double, 7>;
constexpr std::size_t points = 15;

void place(double t, double s_low, double s_high, double* lags) {
  const double middle = t - 0.5 * (s_low + s_high), half = 0.5 * (s_high - s_low);
  lags[0] = middle;
  for (std::size_t i = 1; i < 8; ++i) {
    lags[2 * i - 1] = middle - half * Rule::abscissa()[i];
    lags[2 * i] = middle + half * Rule::abscissa()[i];
  }
}

bool panel(const double* q, double length, Moments& out) {
  double k0 = 0, k1 = 0, g0 = 0, g1 = 0, magnitude = 0;
  for (std::size_t p = 0; p < points; ++p) {
    const std::size_t i = (p + 1) / 2;
    const double sign = p == 0 ? 0 : (p % 2 == 1 ? -1 : 1);
    const double x = 0.5 * (1 + sign * Rule::abscissa()[i]);
    const double w = 0.5 * Rule::weights()[i];
    k0 += w * q[p];
    k1 += w * q[p] * x;
    magnitude += w * std::abs(q[p]);
    if (i % 2 == 0) {
      g0 += 0.5 * Gauss::weights()[i / 2] * q[p];
      g1 += 0.5 * Gauss::weights()[i / 2] * q[p] * x;
    }
  }
  out = {length * k0, length * k1};
  const double bound = 2e-12 * magnitude;
  return std::abs(k0 - g0) <= bound && std::abs(k1 - g1) <= bound;
}

} // namespace

std::span<const Moments> PastWeights::operator()(const PreparedKernel& kernel, const TimeGrid& grid,
                                                 double t, std::span<const double> times,
                                                 std::size_t steps_after) {
  const std::size_t count = times.size() - 1;
  weights_.resize(count);
  if (count == 0) return weights_;
  if (!kernel.traits.convolution || !grid.continues_uniformly(t)) {
    by_panels(kernel, t, times);
    return weights_;
  }
  const std::size_t oldest = count + steps_after;
  while (by_index_.size() <= oldest) by_index(kernel, grid.uniform_step());
  for (std::size_t j = 0; j < count; ++j) weights_[j] = by_index_[oldest - j];
  return weights_;
}

void PastWeights::by_index(const PreparedKernel& kernel, double step) {
  const double m = static_cast<double>(by_index_.size());
  by_index_.push_back(kernel.integral(0.0, m * step, (m + 1) * step));
}

void PastWeights::by_panels(const PreparedKernel& kernel, double t, std::span<const double> times) {
  const std::size_t count = times.size() - 1;
  lags_.resize(points * count);
  values_.resize(points * count);
  for (std::size_t j = 0; j < count; ++j) place(t, times[j], times[j + 1], &lags_[points * j]);
  kernel.function.evaluate(t, lags_, values_);
  for (std::size_t j = 0; j < count; ++j) {
    const double low = t - times[j + 1], high = t - times[j];
    if (!panel(&values_[points * j], high - low, weights_[j])) {
      weights_[j] = kernel.integral(t, low, high);
    }
  }
}

void put_node_weights(std::span<const Moments> intervals, int order, std::vector<double>& nodes) {
  nodes.assign(intervals.size() + (order == 1 ? 1 : 0), 0.0);
  for (std::size_t j = 0; j < intervals.size(); ++j) {
    if (order == 0) {
      nodes[j] = intervals[j].zero;
    } else {
      nodes[j] += intervals[j].one;
      nodes[j + 1] += intervals[j].zero - intervals[j].one;
    }
  }
}

} // namespace hvi::solver
