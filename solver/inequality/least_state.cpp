// A step's state of least energy (engine.hpp): the best of the solutions that Newton's method finds
// from the last state, from released points, from nothing and near the states that the bounds of
// least_energy.hpp suggest; with the bound.
#include "solver/inequality/engine.hpp"
#include "solver/inequality/least_energy.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {
/// Boxes cost a dense product each.
constexpr int most_points_bounded = 300;
} // namespace

Vector InequalityEngine::forces_of(const InequalityState& now) const {
  Vector out(n_points);
  for (int p = 0; p < n_points; ++p) out[p] = points[p].weight * now.xi[points[p].first];
  return out;
}

/// The solution that Newton's method and releases reach from the body under these forces.
Vector InequalityEngine::descend(const Vector& force_at, const Vector& free,
                                 InequalityState& found) {
  InequalityState from;
  from.c = free - response * force_at;
  from.xi = Vector::Zero(n_rows);
  for (int p = 0; p < n_points; ++p) from.xi[points[p].first] = force_at[p] / points[p].weight;
  load(from);
  if (solve_components() != Outcome::solved) return {};
  found = {};
  store(found);
  return forces_of(found);
}

void InequalityEngine::find_least_energy(const Vector& b, const Vector& free, InequalityState& io) {
  if (n_points > most_points_bounded) return;
  std::vector<CurvePoint> all;
  for (const PointData& q : points) all.push_back({&curve_graphs[q.law], q.weight});
  LeastEnergy least(curve->compliance(), std::move(all));
  const InequalityReport at_once = report;
  const InequalityState first = io;
  InequalityState found, best;
  Vector start = Vector::Zero(n_points);
  double ignored = 0.0, lowest = std::numeric_limits<double>::infinity();
  const auto descend_and_keep = [&](const Vector& force_at) -> Vector {
    Vector reached = descend(force_at, free, found);
    if (reached.size() == 0) return reached;
    const double e = least.energy(b, reached, ignored);
    if (e < lowest) lowest = e, best = found;
    return reached;
  };
  if (report.converged)
    start = forces_of(io);
  else if (const Vector reached = descend_and_keep(start); reached.size() > 0)
    start = reached;
  if (const double e = least.energy(b, start, ignored); e < lowest) lowest = e;
  const LeastEnergy::Result result = least.search(b, start, descend_and_keep);
  report.least_gap = result.gap();
  if (best.c.size() != n) return;
  load(best);
  if (accept_found(io)) return;
  io = first, report = at_once; // not certified: what is left is the state that was
}

/// Every solution on the curve through the last state, however often it turns, against the best of
/// those that were found without it.
void InequalityEngine::least_on_curve(const Vector& z0, const Vector& xi0, const Vector& b1,
                                      const Vector& free, InequalityState& io) {
  const auto energy_at = [&](const Vector& at) {
    c = at;
    update_product();
    update_z();
    return energy();
  };
  double lowest = report.converged ? energy_at(io.c) : std::numeric_limits<double>::infinity();
  std::optional<CurveSolution> best;
  curve->visit(z0, xi0, b1, [&] {
    CurveSolution found = on_curve(free);
    const double e = energy_at(found.c);
    if (!(e < lowest - 1e-9 * std::abs(lowest)) && std::isfinite(lowest)) return;
    lowest = e, best = std::move(found);
  });
  report.inner_steps = curve->steps();
  if (!best) return;
  const InequalityReport at_once = report;
  const InequalityState other = io;
  if (settle_on(*best, io)) return;
  io = other, report = at_once;
}

} // namespace hvi::solver
