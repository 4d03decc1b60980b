// A step's state of least energy (least_state.hpp): the best of the solutions that Newton's method
// finds from the last state, from released points, from nothing and near the states that the bounds
// of least_energy.hpp suggest; with the bound.
#include "solver/inequality/least_state.hpp"

#include "solver/inequality/least_energy.hpp"

#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

/// Boxes cost a dense product each.
constexpr int most_points_bounded = 300;

} // namespace

/// The solution that Newton's method and releases reach from the body under these forces, and its
/// forces; empty where there is none.
Vector LeastState::reach(StepAnswer& step, const Vector& force, const Vector& free,
                         InequalityState& found) {
  InequalityState from;
  from.c = curve_.displaced(free, force);
  from.xi = curve_.multipliers(force);
  step.at.load(from);
  if (components_.solve(step.at, step.methods, step.report) != MethodOutcome::solved) return {};
  found = {};
  step.at.store(found);
  return curve_.forces(found.xi);
}

void LeastState::descend(StepAnswer& step, const Vector& b, const Vector& free) {
  const ContactPoints& points = step.at.points;
  if (points.size() > most_points_bounded) return;
  const LeastEnergy least(curve_.curve().compliance(), curve_.curve_points());
  const InequalityReport at_once = step.report;
  const InequalityState first = step.io;
  InequalityState found, best;
  Vector start = Vector::Zero(curve_.curve().compliance().rows());
  double lowest = std::numeric_limits<double>::infinity();
  const auto descend_and_keep = [&](const Vector& force) -> Vector {
    Vector reached = reach(step, force, free, found);
    if (reached.size() == 0) return reached;
    const double e = least.energy(b, reached).value;
    if (e < lowest) lowest = e, best = found;
    return reached;
  };
  if (step.report.converged)
    start = curve_.forces(step.io.xi);
  else if (const Vector reached = descend_and_keep(start); reached.size() > 0)
    start = reached;
  if (const double e = least.energy(b, start).value; e < lowest) lowest = e;
  step.report.least_gap = least.search(b, start, descend_and_keep).gap();
  if (best.c.size() != points.unknowns) return;
  step.at.load(best);
  if (accept_answer(step, tolerance_)) return;
  step.io = first, step.report = at_once; // not certified: what is left is the state that was
}

void LeastState::along_curve(StepAnswer& step, const Vector& b, const Vector& free,
                             const std::function<bool(const CurveSolution&)>& settle_on) {
  const auto energy_at = [&](const Vector& c) {
    step.at.c = c;
    step.at.balance.product.update(c);
    step.at.update_arguments();
    return energy(step.at);
  };
  double lowest =
      step.report.converged ? energy_at(step.io.c) : std::numeric_limits<double>::infinity();
  std::optional<CurveSolution> best;
  const Vector xi = curve_.on_curve(step.start.xi);
  const auto consider = [&](const CurveState& at) {
    CurveSolution found = curve_.solution(at, free);
    const double e = energy_at(found.c);
    if (!(e < lowest - 1e-9 * std::abs(lowest)) && std::isfinite(lowest)) return;
    lowest = e, best = std::move(found);
  };
  step.report.inner_steps = curve_.curve().visit(curve_.start(step.start), xi, b, consider);
  if (!best) return;
  const InequalityReport at_once = step.report;
  const InequalityState other = step.io;
  if (settle_on(*best)) return;
  step.io = other, step.report = at_once;
}

} // namespace hvi::solver
