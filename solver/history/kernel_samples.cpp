// Adaptive sampling of a kernel for the fit and its verification.
#include "solver/history/kernel_samples.hpp"

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/legendre.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr std::size_t points_each = 12;
using SampleRule = boost::math::quadrature::gauss<double, points_each>;

struct SampleNode {
  double x, weight;
};

std::array<SampleNode, points_each> gauss_nodes() {
  std::array<SampleNode, points_each> nodes;
  for (std::size_t i = 0; i < points_each / 2; ++i) {
    nodes[2 * i] = {-SampleRule::abscissa()[i], SampleRule::weights()[i]};
    nodes[2 * i + 1] = {SampleRule::abscissa()[i], SampleRule::weights()[i]};
  }
  return nodes;
}

struct SamplePanel {
  double a, b;
  std::array<double, points_each> lag, value, weight;
  double magnitude = 0; ///< int |q|
  double tail = 0;      ///< size of the last two Legendre coefficients
};

SamplePanel sample_panel(const PreparedKernel& kernel, double a, double b) {
  static const auto nodes = gauss_nodes();
  SamplePanel p{a, b, {}, {}, {}, 0, 0};
  for (std::size_t i = 0; i < points_each; ++i) {
    p.lag[i] = 0.5 * (a + b) + 0.5 * (b - a) * nodes[i].x;
    p.weight[i] = 0.5 * (b - a) * nodes[i].weight;
  }
  kernel.function.evaluate(0.0, p.lag, p.value);
  double last = 0, before_last = 0;
  for (std::size_t i = 0; i < points_each; ++i) {
    p.magnitude += p.weight[i] * std::abs(p.value[i]);
    const double c = nodes[i].weight * p.value[i];
    last += c * boost::math::legendre_p(11, nodes[i].x) * 11.5;
    before_last += c * boost::math::legendre_p(10, nodes[i].x) * 10.5;
  }
  p.tail = std::abs(last) + std::abs(before_last);
  return p;
}

/// Panels that double in length, cut at the kernel's breaks and where it is proved to be resolved.
std::vector<double> first_panels(const PreparedKernel& kernel, double low, double high) {
  std::vector<double> ends{low};
  while (ends.back() < high) ends.push_back(std::min(high, 2 * ends.back()));
  const auto breaks = kernel.breaks.inside(0.0, low, high);
  ends.insert(ends.end(), breaks.begin(), breaks.end());
  kernel.function.resolved_edges(0.0, low, high, ends);
  std::sort(ends.begin(), ends.end());
  const auto near = [&](double a, double b) { return b - a <= 1e-13 * b; };
  ends.erase(std::unique(ends.begin(), ends.end(), near), ends.end());
  return ends;
}

void append(KernelSamples& samples, const SamplePanel& p) {
  samples.lag.insert(samples.lag.end(), p.lag.begin(), p.lag.end());
  samples.value.insert(samples.value.end(), p.value.begin(), p.value.end());
  samples.weight.insert(samples.weight.end(), p.weight.begin(), p.weight.end());
  samples.panel_ends.push_back(p.b);
}

} // namespace

double KernelSamples::density(double at) const {
  const double decades = std::max(1.0, std::log(high / low));
  return std::max(1 / high, 1 / (at * decades));
}

std::optional<KernelSamples> sample_kernel(const PreparedKernel& kernel, double low, double high,
                                           double tolerance, std::size_t max_points) {
  KernelSamples samples;
  samples.low = low;
  samples.high = high;
  samples.panel_ends.push_back(low);
  const auto ends = first_panels(kernel, low, high);
  samples.norm = std::abs(kernel.integral(high, 0, low).zero);
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    samples.norm += sample_panel(kernel, ends[i], ends[i + 1]).magnitude;
  }
  std::vector<std::pair<double, double>> open;
  for (std::size_t i = ends.size() - 1; i > 0; --i) open.emplace_back(ends[i - 1], ends[i]);
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    const SamplePanel p = sample_panel(kernel, a, b);
    const double allowed = tolerance * samples.norm * samples.density(b);
    if (p.tail > 0.05 * allowed + 1e-15 * p.magnitude / (b - a)) {
      if (samples.lag.size() + open.size() * points_each > max_points) return std::nullopt;
      open.emplace_back(0.5 * (a + b), b);
      open.emplace_back(a, 0.5 * (a + b));
      continue;
    }
    append(samples, p);
  }
  return samples;
}

} // namespace hvi::solver
