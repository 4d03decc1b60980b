// Ladders, orders, fronts; see ladder.hpp.
#include "solver/study/ladder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

std::vector<std::vector<int>> combinations(std::span<const int> rungs) {
  std::vector<std::vector<int>> out = {{}};
  for (const int count : rungs) {
    std::vector<std::vector<int>> longer;
    for (const auto& setting : out)
      for (int k = 0; k < count; ++k) {
        longer.push_back(setting);
        longer.back().push_back(k);
      }
    out = std::move(longer);
  }
  return out;
}

std::optional<double> observed_order(double coarse_error, double fine_error, double ratio) {
  if (!(coarse_error > 0.0) || !(fine_error > 0.0) || !(ratio > 0.0) || ratio == 1.0)
    return std::nullopt;
  return std::log(coarse_error / fine_error) / std::log(ratio);
}

std::vector<bool> pareto_front(std::span<const double> cost, std::span<const double> error) {
  std::vector<bool> front(cost.size(), true);
  for (std::size_t i = 0; i < cost.size(); ++i)
    for (std::size_t j = 0; j < cost.size(); ++j) {
      const bool no_worse = cost[j] <= cost[i] && error[j] <= error[i];
      const bool better = cost[j] < cost[i] || error[j] < error[i];
      if (!std::isfinite(error[i]) || (std::isfinite(error[j]) && no_worse && better))
        front[i] = false;
    }
  return front;
}

namespace {

/// The best constant for an order, and the squared misfit of the logarithms it leaves. `power`:
/// 1 for errors that add up, 2 for orthogonal ones.
double misfit(std::span<const double> scales, std::span<const double> distances, double p,
              double power, double& log_c) {
  std::vector<double> off;
  for (std::size_t i = 0; i < distances.size(); ++i)
    off.push_back(std::log(distances[i]) - std::log(std::pow(scales[i], -p * power) - 1.0) / power);
  log_c = 0.0;
  for (const double v : off) log_c += v / static_cast<double>(off.size());
  double sum = 0.0;
  for (const double v : off) sum += (v - log_c) * (v - log_c);
  return sum;
}

} // namespace

/// After L. F. Richardson, The approximate arithmetical solution by finite differences of physical
/// problems involving differential equations, Phil. Trans. R. Soc. A 210 (1911) 307-357.
std::optional<Richardson> richardson(std::span<const double> scales,
                                     std::span<const double> distances) {
  if (distances.size() < 2 || scales.size() != distances.size()) return std::nullopt;
  for (std::size_t i = 0; i < distances.size(); ++i)
    if (!(distances[i] > 0.0) || !(scales[i] > 0.0) || !(scales[i] < 1.0)) return std::nullopt;
  Richardson best;
  double log_c = 0.0, least = std::numeric_limits<double>::infinity();
  for (const double power : {1.0, 2.0})
    for (int k = 5; k <= 600; ++k) { // orders to two digits: no data of a study say more
      double c = 0.0;
      const double p = 0.01 * k, here = misfit(scales, distances, p, power, c);
      if (here < least) least = here, best.order = p, log_c = c;
    }
  for (const double s : scales) best.errors.push_back(std::exp(log_c) * std::pow(s, -best.order));
  best.errors.push_back(std::exp(log_c));
  return best;
}

} // namespace hvi::solver
