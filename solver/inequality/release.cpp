// Downward jumps (release.hpp).
//
// Around a downward jump the law's potential is the smaller of two components' potentials, each
// extended beyond the jump. So a solution with a point beyond its component's end still has energy
// to lose: the point moves to the next component (an event) and the problem is solved again. The
// energy falls with every move, so no set of components comes back.
#include "solver/inequality/release.hpp"

#include "solver/inequality/fallback.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

Release release_next(Position& at, double window) {
  struct Crossing {
    double when;
    int point, step;
  };
  const ContactPoints& points = at.points;
  std::vector<Crossing> crossings;
  for (int p = 0; p < points.size(); ++p) {
    const PreparedLaw& law = points.law(p);
    if (law.components() == 1) continue;
    const LawComponent& k = law.component(at.places.component[p]);
    const double now = size_of(law, points[p].of(at.z)),
                 was = size_of(law, points[p].of(at.z_start)), eps = at.snap(p);
    const bool above = now > k.high + eps, below = now < k.low - eps;
    if (!above && !below) continue;
    const double when = (above ? k.high : k.low) - was;
    crossings.push_back(
        {now == was ? 0.0 : std::clamp(when / (now - was), 0.0, 1.0), p, above ? 1 : -1});
  }
  double first = 2.0;
  for (const Crossing& x : crossings) first = std::min(first, x.when);
  int moved = 0;
  for (const Crossing& x : crossings) {
    if (x.when > first + window) continue;
    const LawComponent& k = points.law(x.point).component(at.places.component[x.point] += x.step);
    at.places.state[x.point] = 2 * (x.step > 0 ? k.first : k.last);
    at.places.enter(x.point, at.z, at.xi);
    ++moved;
  }
  return {moved, std::min(first, 1.0)};
}

void count_events(const Position& at, const std::vector<int>& before, InequalityReport& report) {
  report.events = report.reattached = 0;
  for (int p = 0; p < at.points.size(); ++p) count_crossings(at, p, before[p], report);
}

void count_crossings(const Position& at, int p, int before, InequalityReport& report) {
  const PreparedLaw& law = at.points.law(p);
  const int now = at.places.component[p];
  const bool up = now > before;
  const int low = std::min(before, now), high = std::max(before, now);
  report.events += high - low;
  for (int k = low; k < high; ++k) {
    const int b = law.component(k).last; // the break at its end
    const double below = std::abs(law.graph().left[b]), above = std::abs(law.graph().right[b]);
    report.reattached += up ? above > below : below > above;
  }
}

double energy(const Position& at) {
  double sum = 0.5 * at.c.dot(at.balance.product.value()) - at.balance.load().dot(at.c);
  for (int p = 0; p < at.points.size(); ++p) {
    const PreparedLaw& law = at.points.law(p);
    const double x = size_of(law, at.points[p].of(at.z));
    sum += at.points[p].weight * law.law().potential(law.graph(), piece_of(law.graph(), x), x);
  }
  return sum;
}

ComponentSearch::ComponentSearch(LastFactor& factor, ActiveSetNewton& newton,
                                 const InequalityOptions& options)
    : factor_(factor), newton_(newton), options_(options) {}

/// Newton's method on the present components, then the globally convergent one from the same place.
MethodOutcome ComponentSearch::solve_here(Position& at, Methods methods, InequalityReport& report) {
  c_start_ = at.c, xi_start_ = at.xi, state_start_ = at.places.state;
  const auto outcome = options_.force_fallback ? MethodOutcome::failed
                                               : newton_.solve(at, options_.max_iterations, report);
  if (outcome == MethodOutcome::solved || methods == Methods::newton) return outcome;
  at.c = c_start_, at.xi = xi_start_, at.places.state = state_start_;
  at.update_arguments();
  at.enter_states();
  return solve_globally(at, factor_, newton_, options_, report);
}

void ComponentSearch::Place::take(const Position& at) {
  c = at.c, xi = at.xi, z_start = at.z_start;
  state = at.places.state, component = at.places.component;
  z_hat = at.places.z_hat, xi_hat = at.places.xi_hat, d = at.places.d;
}

void ComponentSearch::Place::give_back(Position& at) const {
  at.c = c, at.xi = xi, at.z_start = z_start;
  at.places.state = state, at.places.component = component;
  at.places.z_hat = z_hat, at.places.xi_hat = xi_hat, at.places.d = d;
  at.update_arguments();
}

/// On the components that the points are on, and those next to them; at last on all at once.
MethodOutcome ComponentSearch::solve(Position& at, Methods methods, InequalityReport& report) {
  component_start_ = at.places.component;
  const bool may_split =
      methods == Methods::all && at.points.laws.may_soften() && factor_.op().symmetric();
  if (may_split) begun_.take(at);
  MethodOutcome outcome = solve_by_components(at, methods, report);
  if (outcome != MethodOutcome::solved && may_split) outcome = solve_by_parts(at, report);
  if (outcome == MethodOutcome::solved) count_events(at, component_start_, report);
  return outcome;
}

/// From where the search began. What failed may be as good as rounding allows, which the
/// certificate says: it stays where this fails, too.
MethodOutcome ComponentSearch::solve_by_parts(Position& at, InequalityReport& report) {
  Place found;
  found.take(at);
  begun_.give_back(at);
  at.enter_states();
  if (solve_by_falls(at, factor_, newton_, options_, report) == MethodOutcome::solved)
    return MethodOutcome::solved;
  found.give_back(at);
  return MethodOutcome::failed;
}

MethodOutcome ComponentSearch::solve_by_components(Position& at, Methods methods,
                                                   InequalityReport& report) {
  const int cap = 20 * at.points.size() + 100;
  int moves = 0;
  for (int round = 0;; ++round) {
    const auto outcome = solve_here(at, methods, report);
    const bool left = outcome == MethodOutcome::left;
    if (outcome != MethodOutcome::solved && !left) return outcome;
    // One by one at first, as under a rising load; in growing groups where many points follow.
    const auto [moved, when] = release_next(at, round < 40 ? 1e-9 : 0.02 * (round - 39));
    if (moved == 0 && left) return MethodOutcome::failed;
    if (moved == 0) break;
    moves += moved;
    if (moves > cap) return MethodOutcome::failed;
    if (left) { // points ran far: no farther than to where the first one left its component
      at.c = c_start_ + when * (at.c - c_start_);
      at.update_arguments();
      at.enter_states();
    }
    at.z_start = at.z;
  }
  return MethodOutcome::solved;
}

namespace {

/// Puts every point beyond the last jump of its law on its side.
void release_all(Position& at) {
  for (int p = 0; p < at.points.size(); ++p) {
    const PreparedLaw& law = at.points.law(p);
    const bool upwards = size_of(law, at.points[p].of(at.z)) >= 0.0;
    at.places.component[p] = upwards ? law.components() - 1 : 0;
    const LawComponent& k = law.component(at.places.component[p]);
    at.places.state[p] = 2 * (upwards ? k.first : k.last);
    at.places.enter(p, at.z, at.xi);
  }
}

} // namespace

MethodOutcome ComponentSearch::solve_branch(Position& at, Methods methods,
                                            InequalityReport& report) {
  if (options_.branch == Branch::continuing || !at.points.laws.may_soften() ||
      !factor_.op().symmetric())
    return solve(at, methods, report);

  InequalityState start;
  at.store(start);
  const std::vector<int> first_components = at.places.component;
  MethodOutcome outcome = solve(at, methods, report);
  InequalityState best;
  at.store(best);
  double lowest =
      outcome == MethodOutcome::solved ? energy(at) : std::numeric_limits<double>::infinity();
  const auto attempt = [&](bool released) {
    at.load(released ? start : InequalityState{});
    if (released) release_all(at);
    if (solve(at, methods, report) != MethodOutcome::solved) return;
    const double e = energy(at);
    if (released && options_.branch == Branch::release)
      lowest = std::numeric_limits<double>::infinity();
    if (!(e < lowest)) return;
    lowest = e, outcome = MethodOutcome::solved;
    at.store(best);
  };
  attempt(true);
  if (options_.branch == Branch::least_energy) attempt(false);
  at.load(best);
  count_events(at, first_components, report);
  return outcome;
}

} // namespace hvi::solver
