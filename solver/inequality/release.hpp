// Downward jumps: solving on fixed components, then moving points that left theirs (release.cpp).
#pragma once

#include "solver/inequality/active_set.hpp"
#include "solver/inequality/last_factor.hpp"

namespace hvi::solver {

struct Release {
  int moved = 0;     ///< points
  double when = 1.0; ///< the part of the way after which the first one leaves
};
/// Moves the points that leave their component first on the way from z_start to z: those within
/// `window` of the earliest.
Release release_next(Position& at, double window);
/// Counts in `report` the jumps between a component and the one that the point stands on now, and
/// which way they were crossed.
void count_crossings(const Position& at, int p, int before, InequalityReport& report);
/// The same for all points, from 0.
void count_events(const Position& at, const std::vector<int>& before, InequalityReport& report);
/// c S c / 2 - r c + sum w j(z), S c as it is kept.
double energy(const Position& at);

enum class Methods { newton, all };

class ComponentSearch {
public:
  ComponentSearch(LastFactor& factor, ActiveSetNewton& newton, const InequalityOptions& options);
  /// From the present place, with points moved on that leave a component of their law.
  MethodOutcome solve(Position& at, Methods methods, InequalityReport& report);
  /// The branch that was asked for: the continued one; the one reached from a state with every
  /// point released; or of these and a cold start the one with the lowest energy.
  MethodOutcome solve_branch(Position& at, Methods methods, InequalityReport& report);

private:
  /// All of a position that a search moves.
  struct Place {
    void take(const Position& at);
    void give_back(Position& at) const;

    Vector c, xi, z_start, z_hat, xi_hat;
    std::vector<int> state, component;
    PointMatrices d;
  };
  MethodOutcome solve_by_parts(Position& at, InequalityReport& report);
  MethodOutcome solve_by_components(Position& at, Methods methods, InequalityReport& report);
  MethodOutcome solve_here(Position& at, Methods methods, InequalityReport& report);

  LastFactor& factor_;
  ActiveSetNewton& newton_;
  const InequalityOptions& options_;
  // Room for a solve.
  Place begun_;
  Vector c_start_, xi_start_;
  std::vector<int> state_start_, component_start_;
};

} // namespace hvi::solver
