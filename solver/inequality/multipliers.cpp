// Multipliers from arguments (multipliers.hpp).
#include "solver/inequality/multipliers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

/// Of a multiplier.
constexpr double rounding_of_inclusion = 1e-14;

/// A slope of the point's component; at an end of the piece that the point is on that of this
/// piece, not of its neighbour. One that stands for infinity is no multiplier: a state with it is
/// no solution.
double slope_at(const PreparedLaw& law, int component, int state, double r) {
  const LawComponent& k = law.component(component);
  const LawGraph& g = law.graph();
  const int piece = state / 2;
  const bool at_low = state >= 0 && state % 2 == 0 && piece > k.first && r == g.breaks[piece - 1];
  const double s = at_low ? g.right[piece - 1] : law.on_component(component, r).s;
  return std::abs(s) < unbounded_slope ? s : std::numeric_limits<double>::quiet_NaN();
}

double clipped(const LawGraph& g, int i, double v) {
  return std::clamp(v, std::min(g.left[i], g.right[i]), std::max(g.left[i], g.right[i]));
}

double certain_scalar(const Position& at, int p, double z, double xi) {
  const PointData& q = at.points[p];
  const LawGraph& g = at.points.law(p).graph();
  const double tolerance = at.snap(p);
  const int state = at.places.state[p], i = state / 2;
  if (state % 2 == 1 && std::abs(z - g.breaks[i]) <= tolerance) return clipped(g, i, xi);
  const double s = slope_at(at.points.law(p), at.places.component[p], state, z);
  // Where the law is far stiffer than the body, rounding of z hides xi: the increments of Newton's
  // steps give it.
  const double stiffness = std::abs(q.block(at.places.d)[0]), slack = stiffness * tolerance;
  const bool stiff = state % 2 == 0 && stiffness * q.local > PointData::far_stiffer;
  return stiff ? std::clamp(xi, s - slack, s + slack) : s;
}

Small certain_radial(const Position& at, int p, const Small& z, const Small& xi) {
  const PreparedLaw& law = at.points.law(p);
  const LawGraph& g = law.graph();
  const double tolerance = at.snap(p), r = norm(z);
  const int state = at.places.state[p], component = at.places.component[p], i = state / 2;
  // A slip that is nothing but rounding has no direction: that of xi counts there, too.
  if ((state == -1 || state == 0) && r <= tolerance) {
    const double ball = std::abs(law.on_component(component, 0.0).s), size = norm(xi);
    return size > ball ? ball / size * xi : xi;
  }
  const Small e = direction_of(z, xi);
  const bool at_break = state % 2 == 1 && state > 0 && std::abs(r - g.breaks[i]) <= tolerance;
  return (at_break ? clipped(g, i, xi.dot(e)) : slope_at(law, component, state, r)) * e;
}

} // namespace

Small certain_multiplier(const Position& at, int p) {
  const Small z = at.points[p].of(at.z), xi = at.points[p].of(at.xi);
  if (at.points[p].given) return least_multiplier(at.points.law(p), z);
  if (at.points.law(p).radial()) return certain_radial(at, p, z, xi);
  return along_first(at.points[p].rows, certain_scalar(at, p, z[0], xi[0]));
}

bool balance_point(const Position& at, int p, const Vector& residual, Vector& trial) {
  const PointData& q = at.points[p];
  const PreparedLaw& law = at.points.law(p);
  const Small before = q.of(trial);
  Small value = before;
  for (int k = 0; k < q.rows; ++k)
    for (SparseMatrix::InnerIterator it(at.points.g, q.first + k); it; ++it)
      value[k] += residual[it.col()] / (q.weight * q.share[k] * it.value());
  const Small zp = q.of(at.z);
  const double distance =
      inclusion_distance(law.law(), law.graph(), zp.data(), value.data(), q.rows, at.snap(p));
  if (!(distance <= rounding_of_inclusion * norm(value))) return false;
  q.put(trial, value);
  return value != before;
}

namespace {

/// Does the law turn far more stiffly than the body, and is xi on its graph as far as z is known?
bool may_be_tracked(const Position& at, int p) {
  const PointData& q = at.points[p];
  const PreparedLaw& law = at.points.law(p);
  if (!law.radial() || q.given) return false;
  const Small z = q.of(at.z), xi = q.of(at.xi);
  const double size = norm(xi);
  return size * q.local > PointData::far_stiffer * norm(z) &&
         inclusion_distance(law.law(), law.graph(), z.data(), xi.data(), q.rows, at.snap(p)) <=
             rounding_of_inclusion * size;
}

/// The worst ratio with `of`(p) of all points in `trial`.
template <class Of>
double balanced_ratio(Position& at, double snap_factor, Vector& trial, const Of& of) {
  const ContactPoints& points = at.points;
  at.balance.product.update(at.c);
  at.snap.update(at.c, at.balance, snap_factor);
  trial.resize(points.rows);
  for (int p = 0; p < points.size(); ++p) points[p].put(trial, of(p));
  const Errors& errors = at.balance.errors(at.c, trial);
  bool balanced = false;
  for (int p = 0; p < points.size(); ++p)
    if (points[p].exclusive && at.places.resting(p))
      balanced = balance_point(at, p, errors.left, trial) || balanced;
  return balanced ? at.balance.errors(at.c, trial).worst : errors.worst;
}

} // namespace

double certain_multipliers(Position& at, double snap_factor, Vector& trial) {
  return balanced_ratio(at, snap_factor, trial, [&](int p) { return certain_multiplier(at, p); });
}

double likely_multipliers(Position& at, double snap_factor, Vector& trial) {
  return balanced_ratio(at, snap_factor, trial, [&](int p) {
    return may_be_tracked(at, p) ? at.points[p].of(at.xi) : certain_multiplier(at, p);
  });
}

} // namespace hvi::solver
