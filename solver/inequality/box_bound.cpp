// Bounds on boxes (box_bound.hpp).
#include "solver/inequality/box_bound.hpp"

#include "solver/common/numbers.hpp"
#include "solver/inequality/inequality.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr int most_rounds = 400;
/// Energies are sums that cancel: no bound is better than this part of their terms.
constexpr double energy_rounding = 1e-13;

/// Where a box is cut for a point whose argument is there; at a drop the bound is better on both
/// sides.
double cut_near(const CurveGraph& g, double low, double high, double inside) {
  const double width = high - low;
  double at = std::clamp(inside, low + 0.2 * width, high - 0.2 * width), closest = infinity;
  for (int b = 0; b + 1 < g.pieces(); ++b) {
    const double x = g.at(b), apart = std::abs(x - inside);
    const bool within = x > low + 1e-9 * width && x < high - 1e-9 * width;
    if (within && g.below(b) > g.above(b) && apart < closest) closest = apart, at = x;
  }
  return at;
}

} // namespace

/// E >= shift + sum inf phi + |z - b~|^2 / 2 in the norm of C^-1 - D.
std::optional<EnergyBox> first_box(const SplitEnergy& energy, const LowestEnergy& lowest) {
  double room = lowest.value - energy.shift;
  for (const PointEnergy& law : energy.points) {
    double least = infinity;
    for (int i = 0; i < law.graph->pieces(); ++i) least = std::min(least, law.least_on(i));
    room -= least;
  }
  if (!std::isfinite(room)) return std::nullopt;
  room = std::max(room, 0.0) * (1.0 + 1e-9) + 1e-12 * (std::abs(energy.shift) + lowest.scale);
  EnergyBox box{-infinity, energy.b, energy.b, {}};
  for (Eigen::Index p = 0; p < energy.b.size(); ++p) {
    const PointEnergy& law = energy.points[static_cast<std::size_t>(p)];
    const double reach = std::sqrt(2.0 * energy.compliance(p, p) * room);
    box.low[p] = std::max(law.low, energy.b[p] - reach);
    box.high[p] = std::min(law.high, energy.b[p] + reach);
    if (!(box.low[p] < box.high[p])) return std::nullopt;
  }
  return box;
}

BoxBound::BoxBound(const SplitEnergy& energy, const std::vector<std::vector<EnergyCell>>& cells,
                   const EnergyBox& box)
    : energy_(energy) {
  for (std::size_t p = 0; p < cells.size(); ++p) {
    const auto i = static_cast<Eigen::Index>(p);
    segments_.push_back(make_segments(energy.points[p], cells[p], box.low[i], box.high[i]));
  }
  take(box.multiplier);
}

void BoxBound::take(const Vector& multiplier) {
  lambda_ = multiplier;
  c_lambda_ = energy_.compliance * lambda_;
}

double BoxBound::conjugate_at(int p, double& at) {
  for (const EnergySegment& s : segments_[p]) work_ += s.straight ? 1.0 : 100.0;
  return conjugate(energy_.points[p], segments_[p], lambda_[p], at);
}

/// The best multiplier of one point, the others held: the root of a falling function.
void BoxBound::improve(int p, double box_low, double box_high) {
  const double before = lambda_[p];
  const double c = energy_.compliance(p, p), r = energy_.b[p] - c_lambda_[p] + c * before;
  double low = (r - box_high) / c, high = (r - box_low) / c, at = 0.0;
  double& t = lambda_[p];
  t = std::clamp(before, low, high);
  const double enough = 1e-13 * std::max(std::abs(low), std::abs(high));
  for (int k = 0; k < 60 && high - low > enough; ++k) {
    conjugate_at(p, at);
    const double to = (r - at) / c; // the root lies between t and this
    if (to > t) low = t, high = std::min(high, to);
    if (to < t) high = t, low = std::max(low, to);
    if (std::abs(to - t) <= enough) break;
    t = k < 2 ? std::clamp(to, low, high) : 0.5 * (low + high);
  }
  c_lambda_ += (t - before) * energy_.compliance.col(p);
  work_ += 0.25 * static_cast<double>(lambda_.size());
}

double BoxBound::value() {
  double sum = energy_.shift, at = 0.0, terms = std::abs(energy_.shift);
  for (int p = 0; p < static_cast<int>(lambda_.size()); ++p) {
    const double linear = lambda_[p] * (energy_.b[p] - 0.5 * c_lambda_[p]),
                 law = conjugate_at(p, at);
    sum += linear - law;
    terms += std::abs(linear) + std::abs(law);
  }
  return sum - energy_rounding * terms;
}

void BoxBound::raise(EnergyBox& box, const LowestEnergy& lowest) {
  double last = -infinity;
  for (int k = 0; k < most_rounds; ++k) {
    for (int p = 0; p < static_cast<int>(lambda_.size()); ++p) improve(p, box.low[p], box.high[p]);
    if (k % 4 != 3) continue;
    c_lambda_ = energy_.compliance * lambda_;
    const double now = value(), missing = lowest.value - now;
    if (now > box.bound) box.bound = now, box.multiplier = lambda_;
    if (missing <= 0.1 * proved_least_gap * lowest.scale || now - last <= 1e-2 * missing) break;
    last = now;
  }
  take(box.multiplier);
}

Vector BoxBound::forces() const { return lambda_ - energy_.d.cwiseProduct(energy_.b - c_lambda_); }

std::optional<EnergyCut> BoxBound::worst(const EnergyBox& box) {
  const Vector z = energy_.b - c_lambda_;
  std::optional<EnergyCut> out;
  double most = 0.0, ignored = 0.0;
  for (int p = 0; p < static_cast<int>(z.size()); ++p) {
    const double low = box.low[p], high = box.high[p];
    if (!(high - low > 1e-12 * std::max(std::abs(low), std::abs(high)))) continue;
    const PointEnergy& law = energy_.points[p];
    const double inside = std::clamp(z[p], low, high);
    const double gap = law.at(inside) - lambda_[p] * inside + conjugate_at(p, ignored);
    if (!(gap > most)) continue;
    most = gap;
    out = EnergyCut{p, cut_near(*law.graph, low, high, inside)};
  }
  return out;
}

} // namespace hvi::solver
