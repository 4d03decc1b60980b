// The least energy by branch and bound (least_energy.hpp).
#include "solver/inequality/least_energy.hpp"

#include "solver/inequality/inequality.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace hvi::solver {

namespace {

/// What one search may cost: segments looked at, and entries of products.
constexpr double most_work = 1e8;
constexpr int most_boxes = 20000;
/// Solutions looked for near the bounds' states: always, and where a state has less energy.
constexpr int free_descents = 4, most_descents = 40;

/// The states that bounds suggest, and the lowest energy of the solutions next to them.
class Candidates {
public:
  Candidates(const LeastEnergy& energy, const Vector& b, const LeastEnergy::Descend& descend,
             LowestEnergy& lowest)
      : energy_(energy), b_(b), descend_(descend), lowest_(lowest) {}

  /// Goes on from a state to a solution if that is promising.
  void consider(const Vector& force) {
    const double here = energy_.energy(b_, force).value;
    const bool better = here < lowest_.value - 0.1 * proved_least_gap * lowest_.scale;
    if (!better && descents_ >= free_descents) return;
    if (descents_ >= most_descents) return;
    ++descents_;
    const Vector solved = descend_(force);
    if (solved.size() != b_.size()) return;
    const LowestEnergy there = energy_.energy(b_, solved);
    if (!(there.value < lowest_.value)) return;
    lowest_ = {there.value, std::max(lowest_.scale, there.scale)};
  }

private:
  const LeastEnergy& energy_;
  const Vector& b_;
  const LeastEnergy::Descend& descend_;
  LowestEnergy& lowest_;
  int descents_ = 0;
};

/// Halves boxes, the one with the lowest bound first, until that meets the lowest energy.
void branch_and_bound(const SplitEnergy& split, EnergyBox first, Candidates& candidates,
                      LeastEnergyResult& out) {
  const auto n = split.points.size();
  std::vector<std::vector<EnergyCell>> cells(n);
  for (std::size_t p = 0; p < n; ++p) {
    const auto i = static_cast<Eigen::Index>(p);
    if (!make_cells(split.points[p], first.low[i], first.high[i], cells[p])) return;
  }
  std::priority_queue<EnergyBox> open;
  double work = 0.0;
  const auto look_at = [&](EnergyBox& box) {
    BoxBound bound(split, cells, box);
    bound.raise(box, out.lowest);
    work += bound.work();
    ++out.boxes;
    if (box.bound < out.lowest.value) candidates.consider(bound.forces());
    open.push(std::move(box));
  };
  look_at(first);
  const auto done = [&] {
    return open.empty() ||
           out.lowest.value - open.top().bound <= 0.5 * proved_least_gap * out.lowest.scale;
  };
  while (!done() && work < most_work && out.boxes < most_boxes) {
    EnergyBox box = open.top();
    BoxBound bound(split, cells, box);
    const auto cut = bound.worst(box);
    work += bound.work();
    if (!cut) break;
    open.pop();
    EnergyBox upper = box;
    box.high[cut->point] = cut->at, upper.low[cut->point] = cut->at;
    look_at(box);
    look_at(upper);
  }
  out.bound = open.empty() ? out.lowest.value : std::min(out.lowest.value, open.top().bound);
}

} // namespace

double LeastEnergyResult::gap() const {
  if (!std::isfinite(bound) || !(lowest.scale > 0.0)) return bound >= lowest.value ? 0.0 : infinity;
  return std::max(0.0, (lowest.value - bound) / lowest.scale);
}

LeastEnergy::LeastEnergy(const DenseMatrix& compliance, const std::vector<CurvePoint>& points)
    : c_(compliance), points_(points.begin(), points.end()) {}

LowestEnergy LeastEnergy::energy(const Vector& b, const Vector& force) const {
  const Vector give = c_ * force;
  const double body = 0.5 * force.dot(give);
  LowestEnergy out{body, std::abs(body)};
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const auto i = static_cast<Eigen::Index>(p);
    const double z = b[i] - give[i];
    if (!points_[p].reaches(z)) return {infinity, out.scale};
    const double law = points_[p].law(points_[p].inside(z));
    out.value += law, out.scale += std::abs(law);
  }
  return out;
}

LeastEnergyResult LeastEnergy::search(const Vector& b, const Vector& force,
                                      const Descend& descend) const {
  LeastEnergyResult out;
  out.lowest = energy(b, force);
  if (!std::isfinite(out.lowest.value)) return out;
  const auto split = split_energy(c_, points_, b);
  if (!split) return out;
  // Where no law acts all energies are zero but that of moving the body's arguments.
  out.lowest.scale = std::max(out.lowest.scale, 0.5 * b.dot(split->d.cwiseProduct(b)));
  auto first = first_box(*split, out.lowest);
  if (!first) return out;
  first->multiplier = force + split->d.cwiseProduct(b - c_ * force);
  Candidates candidates(*this, b, descend, out.lowest);
  branch_and_bound(*split, std::move(*first), candidates, out);
  return out;
}

} // namespace hvi::solver
