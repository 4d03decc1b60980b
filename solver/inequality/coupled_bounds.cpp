// Graphs from multipliers (coupled_bounds.hpp).
#include "solver/inequality/coupled_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {
/// The stiffness that holds a resting point in a linear step, over the body's own at the point. The
/// small displacement that it allows is undone by the next step; a larger stiffness would cost
/// digits of the multiplier.
constexpr double holding = 1e8;
} // namespace

CoupledBounds::CoupledBounds(ContactPoints& points, Position& at)
    : points_(points), at_(at), bound_of_(points.data.size(), -1) {
  std::vector<int> point_of(static_cast<std::size_t>(points.rows), -1);
  for (int p = 0; p < points.size(); ++p) point_of[points[p].first] = p;
  for (const CoupledPoint& q : points.problem.coupled) {
    bound_of_[q.point] = static_cast<int>(all.size());
    all.push_back({q.point, point_of[q.row], q.x, {}, 0.0, 0.0, false});
  }
  for (PointData& q : points.data) {
    penalties_.push_back(q.penalty);
    q.penalty = std::min(q.penalty, holding / q.local);
  }
}

CoupledBounds::~CoupledBounds() {
  for (int p = 0; p < points_.size(); ++p) points_.data[p].penalty = penalties_[p];
  points_.laws.refresh(); // the graphs of the problem again
}

void CoupledBounds::set_share(double value) {
  share_ = value;
  for (CoupledBound& b : all) b.known = false;
}

void CoupledBounds::set(CoupledBound& b, double multiplier) {
  if (b.known && b.multiplier == multiplier) return;
  // A trial far inside an obstacle has no finite pressure: the last bound stays.
  if (!(std::abs(multiplier) < unbounded_slope)) {
    if (b.known) return;
    multiplier = 0.0;
  }
  const int law = points_[b.point].law;
  b.multiplier = multiplier, b.known = true;
  b.graph = graph(b, multiplier);
  points_.laws.replace(law, b.graph);
  int& component = at_.places.component[b.point];
  component = std::clamp(component, 0, points_.laws[law].components() - 1);
}

/// At the time and with the readings of the problem's own graph.
LawGraph CoupledBounds::graph(const CoupledBound& b, double multiplier) const {
  const ReducedProblem& problem = points_.problem;
  LawTime when = problem.graphs[static_cast<std::size_t>(problem.points[b.point].graph)].t;
  when.coupled = share_ * multiplier;
  return points_.law(b.point).law().graph(b.x, when);
}

/// By a difference quotient, which is exact where the bound is linear in the multiplier.
double CoupledBounds::slope_rate(const CoupledBound& b) const {
  const Law& law = points_.law(b.point).law();
  const double size = std::max(std::abs(b.multiplier), 1e-6 * at_.xi.lpNorm<Eigen::Infinity>());
  const double step = std::copysign(1e-6 * std::max(size, 1e-300), b.multiplier);
  const LawGraph other = graph(b, b.multiplier + step);
  const double r = norm(points_[b.point].of(at_.places.z_hat));
  const int state = at_.places.state[b.point], piece = state / 2;
  if (other.pieces() != b.graph.pieces() || state < 0) return 0.0;
  const double rate = (law.slope(other, piece, r) - law.slope(b.graph, piece, r)) / step;
  return std::isfinite(rate) ? rate : 0.0;
}

Small CoupledBounds::slip(const CoupledBound& b) const {
  const Small z = points_[b.point].of(at_.places.z_hat);
  const double r = norm(z);
  return r > 0.0 ? Small(z / r) : Small(Small::Zero(z.size()));
}

} // namespace hvi::solver
