// Ladders, orders, fronts; see ladder.hpp.
#include "solver/study/ladder.hpp"

#include <algorithm>
#include <array>
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

constexpr double least_order = 0.05, most_order = 6.0;
constexpr double most_misfit = 0.25; ///< of the squares of distances, relative

/// The squares of a and b that fit best for an order, and what they leave open.
struct Fit {
  double order = 0.0, aa = 0.0, bb = 0.0;
  double misfit = std::numeric_limits<double>::infinity(); ///< root of the mean square
};

/// Least squares of aa A + bb B = 1, A and B relative to the square of each distance.
Fit fit_of(double p, std::span<const RungDistance> distances, Measured measured) {
  std::vector<std::array<double, 2>> rows;
  double AA = 0.0, AB = 0.0, BB = 0.0, A = 0.0, B = 0.0;
  for (const RungDistance& d : distances) {
    const double x = std::pow(d.coarse, -p), y = std::pow(d.fine, -p),
                 square = d.distance * d.distance;
    const double a = (x * x - y * y) / square, b = (x - y) * (x - y) / square;
    rows.push_back({a, b});
    AA += a * a, AB += a * b, BB += b * b, A += a, B += b;
  }
  const auto with = [&](double aa, double bb) {
    Fit out{p, aa, bb, 0.0};
    for (const auto& [a, b] : rows) out.misfit += std::pow(aa * a + bb * b - 1.0, 2);
    out.misfit = std::sqrt(out.misfit / static_cast<double>(rows.size()));
    return out;
  };
  Fit best = with(0.0, B / BB);
  if (measured == Measured::number) return best;
  const double det = AA * BB - AB * AB;
  for (const Fit& other :
       {with(A / AA, 0.0), with((A * BB - B * AB) / det, (B * AA - A * AB) / det)})
    if (other.aa >= 0.0 && other.bb >= 0.0 && other.misfit < best.misfit) best = other;
  return best;
}

/// Steps of a hundredth find the valley, those of a ten thousandth its ground.
Fit best_fit(std::span<const RungDistance> distances, Measured measured) {
  Fit best;
  const auto search = [&](double from, double to, double step) {
    for (int k = 0; from + k * step <= to; ++k)
      if (const Fit here = fit_of(from + k * step, distances, measured); here.misfit < best.misfit)
        best = here;
  };
  search(least_order, most_order, 0.01);
  const double near = best.order;
  search(std::max(near - 0.01, least_order), near + 0.01, 1e-4);
  return best;
}

} // namespace

double Richardson::error(double distance) const {
  return std::sqrt(distance * distance + finest * finest + 2.0 * along * finest * distance);
}

/// After L. F. Richardson, The approximate arithmetical solution by finite differences of physical
/// problems involving differential equations, Phil. Trans. R. Soc. A 210 (1911) 307-357.
std::optional<Richardson> richardson(std::span<const RungDistance> distances, Measured measured) {
  if (distances.size() < (measured == Measured::number ? 2U : 3U)) return std::nullopt;
  double nearest = 0.0;
  for (const RungDistance& d : distances) {
    if (!(d.distance > 0.0) || !(d.coarse > 0.0) || !(d.coarse < d.fine)) return std::nullopt;
    nearest = std::max(nearest, d.coarse);
  }
  const Fit fit = best_fit(distances, measured);
  if (!(fit.misfit < most_misfit) || !(fit.order > least_order) || !(fit.order < most_order))
    return std::nullopt;
  const double x = std::pow(nearest, -fit.order);
  const double in_b = fit.bb * (x - 1.0), in_all = in_b + fit.aa * (x + 1.0);
  const double finest = std::sqrt(fit.aa + fit.bb);
  return Richardson{fit.order, finest, std::sqrt(fit.bb * in_b / in_all) / finest};
}

} // namespace hvi::solver
