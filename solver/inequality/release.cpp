// Downward jumps: solving on fixed components, then moving points that left theirs (engine.hpp).
//
// Around a downward jump the law's potential is the smaller of two components' potentials, each
// extended beyond the jump. So a solution with a point beyond its component's end still has energy
// to lose: the point moves to the next component (an event) and the problem is solved again. The
// energy falls with every move, so no set of components comes back.
#include "solver/inequality/engine.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {
double size_of(const PreparedLaw& law, const Small& z) {
  return law.radial() ? std::hypot(z[0], z[1], z[2]) : z[0];
}
} // namespace

/// Moves the points that leave their component first on the way from z_start to z: those within
/// `window` of the earliest. Returns their number.
int InequalityEngine::release_next(double window) {
  struct Crossing {
    double when;
    int point, step;
  };
  std::vector<Crossing> crossings;
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    if (law.components() == 1) continue;
    const LawComponent& k = law.component(component[p]);
    const double now = size_of(law, at(z, p)), was = size_of(law, at(z_start, p)), eps = snap(p);
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
    const PreparedLaw& law = prepared[points[x.point].law];
    const LawComponent& k = law.component(component[x.point] += x.step);
    state[x.point] = 2 * (x.step > 0 ? k.first : k.last);
    enter_state(x.point);
    ++moved;
  }
  return moved;
}

InequalityEngine::Outcome InequalityEngine::solve_components() {
  components_before = component;
  const int cap = 20 * n_points + 100;
  int moves = 0;
  for (int round = 0;; ++round) {
    c_at_start = c, xi_at_start = xi, state_at_start = state;
    Outcome outcome = options.force_fallback ? Outcome::failed : newton(options.max_iterations);
    if (outcome != Outcome::solved && newton_only) return outcome;
    if (outcome != Outcome::solved) {
      c = c_at_start, xi = xi_at_start, state = state_at_start;
      update_z();
      for (int p = 0; p < n_points; ++p) enter_state(p);
      outcome = fallback();
    }
    if (outcome != Outcome::solved) return outcome;
    // One by one at first, as along a rising load; a collapse of many points in growing groups.
    const int moved = release_next(round < 40 ? 1e-9 : 0.02 * (round - 39));
    if (moved == 0) break;
    moves += moved;
    if (moves > cap) return Outcome::failed;
    z_start = z;
  }
  count_events(components_before);
  return Outcome::solved;
}

/// Downward jumps crossed since the points stood on those components.
void InequalityEngine::count_events(const std::vector<int>& before) {
  report.events = report.reattached = 0;
  for (int p = 0; p < n_points; ++p) count_crossings(p, before[p]);
}

/// The jumps between a component and the one that the point stands on now, and which way they were
/// crossed.
void InequalityEngine::count_crossings(int p, int before) {
  const PreparedLaw& law = prepared[points[p].law];
  const bool up = component[p] > before;
  const int low = std::min(before, component[p]), high = std::max(before, component[p]);
  report.events += high - low;
  for (int k = low; k < high; ++k) {
    const int b = law.component(k).last; // the break at its end
    const double below = std::abs(law.graph().left[b]), above = std::abs(law.graph().right[b]);
    report.reattached += up ? above > below : below > above;
  }
}

double InequalityEngine::energy() const {
  double sum = 0.5 * c.dot(sc) - rhs->dot(c);
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    const double x = size_of(law, at(z, p));
    sum += points[p].weight * law.law().potential(law.graph(), piece_of(law.graph(), x), x);
  }
  return sum;
}

/// The branch that was asked for: the continued one; the one reached from a state with every point
/// released; or of these and a cold start the one with the lowest energy.
InequalityEngine::Outcome InequalityEngine::solve_branch() {
  bool alternatives = false;
  for (const PreparedLaw& law : prepared) alternatives = alternatives || law.components() > 1;
  for (const PreparedLaw& law : prepared)
    for (int k = 0; k < law.components(); ++k)
      alternatives = alternatives || law.component(k).m > 0.0;
  if (options.branch == Branch::continuing || !alternatives || !op.symmetric())
    return solve_components();

  InequalityState start;
  store(start);
  const std::vector<int> first_components = component;
  Outcome outcome = solve_components();
  InequalityState best;
  store(best);
  double lowest = outcome == Outcome::solved ? energy() : std::numeric_limits<double>::infinity();
  const auto attempt = [&](bool released) {
    load(released ? start : InequalityState{});
    for (int p = 0; released && p < n_points; ++p) {
      const PreparedLaw& law = prepared[points[p].law];
      const bool upwards = size_of(law, at(z, p)) >= 0.0;
      component[p] = upwards ? law.components() - 1 : 0;
      const LawComponent& k = law.component(component[p]);
      state[p] = 2 * (upwards ? k.first : k.last);
      enter_state(p);
    }
    if (solve_components() != Outcome::solved) return;
    const double e = energy();
    if (released && options.branch == Branch::release)
      lowest = std::numeric_limits<double>::infinity();
    if (!(e < lowest)) return;
    lowest = e, outcome = Outcome::solved;
    store(best);
  };
  attempt(true);
  if (options.branch == Branch::least_energy) attempt(false);
  load(best);
  count_events(first_components);
  return outcome;
}

} // namespace hvi::solver
