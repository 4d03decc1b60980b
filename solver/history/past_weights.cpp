// Weights of many intervals at once.
#include "solver/history/past_weights.hpp"

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// A Kronrod rule with its embedded Gauss rule, on intervals that are evaluated together.
template <unsigned Points>
struct Panel {
  using Rule = boost::math::quadrature::gauss_kronrod<double, Points>;
  using Gauss = boost::math::quadrature::gauss<double, Points / 2>;

  static void place(double low, double high, double* lags) {
    const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    lags[0] = middle;
    for (std::size_t i = 1; i <= Points / 2; ++i) {
      lags[2 * i - 1] = middle - half * Rule::abscissa()[i];
      lags[2 * i] = middle + half * Rule::abscissa()[i];
    }
  }

  /// False when the two rules differ: the interval needs more points.
  static bool sum(const double* q, double length, Moments& out) {
    double k0 = 0, k1 = 0, g0 = 0, g1 = 0, magnitude = 0;
    for (std::size_t p = 0; p < Points; ++p) {
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
};

} // namespace

std::span<const Moments> PastWeights::operator()(const PreparedKernel& kernel,
                                                 std::optional<double> step, double t,
                                                 std::span<const double> times,
                                                 std::size_t steps_after) {
  const std::size_t count = times.size() - 1;
  weights_.resize(count);
  if (count == 0) return weights_;
  if (!kernel.traits.convolution || !step) {
    intervals_.clear();
    for (std::size_t j = 0; j < count; ++j) intervals_.push_back({t - times[j + 1], t - times[j]});
    integrate(kernel, t, weights_);
    return weights_;
  }
  const std::size_t oldest = count + steps_after;
  if (by_index_.size() <= oldest) by_index(kernel, *step, oldest + 1);
  for (std::size_t j = 0; j < count; ++j) weights_[j] = by_index_[oldest - j];
  return weights_;
}

void PastWeights::by_index(const PreparedKernel& kernel, double step, std::size_t count) {
  const std::size_t known = by_index_.size();
  intervals_.clear();
  for (std::size_t m = known; m < count; ++m) {
    const double index = static_cast<double>(m);
    intervals_.push_back({index * step, (index + 1) * step});
  }
  by_index_.resize(count);
  integrate(kernel, 0.0, {by_index_.data() + known, count - known});
}

void PastWeights::integrate(const PreparedKernel& kernel, double t, std::span<Moments> out) {
  open_.clear();
  if (intervals_.empty()) return;
  if (!kernel.traits.convolution) {
    double low = intervals_.front().low, high = intervals_.front().high;
    for (const Interval& i : intervals_) {
      low = std::min(low, i.low);
      high = std::max(high, i.high);
    }
    edges_[0].clear();
    kernel.function.resolved_edges(t, low, high, edges_[0]);
    std::sort(edges_[0].begin(), edges_[0].end());
  }
  done_exactly(kernel, t, out);
  try_panels<7>(kernel, t, out);
  try_panels<15>(kernel, t, out);
  for (const std::size_t j : open_) {
    out[j] = kernel.integral(t, intervals_[j].low, intervals_[j].high);
  }
}

/// What is found for an interval of a convolution depends on the interval alone, so that a step
/// that is given up leaves no trace.
const std::vector<double>& PastWeights::edges(const PreparedKernel& kernel, double t,
                                              const Interval& i) {
  if (!kernel.traits.convolution) return edges_[0];
  const int k = std::ilogb(i.high) + 1;
  const auto [entry, fresh] = edges_.try_emplace(k);
  if (fresh) {
    kernel.function.resolved_edges(t, 0, std::ldexp(1.0, k), entry->second);
    std::sort(entry->second.begin(), entry->second.end());
  }
  return entry->second;
}

/// At most three panels: 15 points resolve them all.
bool PastWeights::resolved(const PreparedKernel& kernel, double t, const Interval& i) {
  const auto& ends = edges(kernel, t, i);
  const auto first = std::upper_bound(ends.begin(), ends.end(), i.low);
  const auto last = std::lower_bound(first, ends.end(), i.high);
  return last - first <= 2;
}

/// Intervals that touch lag 0 or have a break inside: a few points could miss what is there. The
/// others stay open.
void PastWeights::done_exactly(const PreparedKernel& kernel, double t, std::span<Moments> out) {
  const Breaks& breaks = kernel.breaks;
  std::vector<double> inside;
  if (!breaks.empty() && !breaks.searched()) {
    double low = intervals_.front().low, high = intervals_.front().high;
    for (const Interval& i : intervals_) {
      low = std::min(low, i.low);
      high = std::max(high, i.high);
    }
    inside = breaks.inside(t, low, high);
  }
  for (std::size_t j = 0; j < intervals_.size(); ++j) {
    const auto [low, high] = intervals_[j];
    bool special = low <= 0 || !resolved(kernel, t, intervals_[j]);
    if (breaks.searched()) {
      special = special || !breaks.inside(t, low, high).empty();
    } else if (!inside.empty()) {
      const auto next = std::upper_bound(inside.begin(), inside.end(), low);
      special = special || (next != inside.end() && *next < high);
    }
    if (special) {
      out[j] = kernel.integral(t, low, high);
    } else {
      open_.push_back(j);
    }
  }
}

template <unsigned Points>
void PastWeights::try_panels(const PreparedKernel& kernel, double t, std::span<Moments> out) {
  lags_.resize(Points * open_.size());
  values_.resize(Points * open_.size());
  double* lags = lags_.data();
  for (const std::size_t j : open_) {
    Panel<Points>::place(intervals_[j].low, intervals_[j].high, lags);
    lags += Points;
  }
  kernel.function.evaluate(t, lags_, values_);
  const double* values = values_.data();
  std::erase_if(open_, [&](std::size_t j) {
    const bool good = Panel<Points>::sum(values, intervals_[j].high - intervals_[j].low, out[j]);
    values += Points;
    return good;
  });
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
