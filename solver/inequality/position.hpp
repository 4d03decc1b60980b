// Where a search for a solution of the reduced inequality stands, with what is known there.
#pragma once

#include "solver/inequality/force_balance.hpp"
#include "solver/inequality/graph_states.hpp"
#include "solver/inequality/snap.hpp"

namespace hvi::solver {

struct Position {
  /// `target`: the componentwise residual that solves aim at.
  Position(const ContactPoints& points, const ReducedOperator& s, double target);
  /// Goes to the warm start, or to its guess where it has one.
  void load(const InequalityState& from);
  void store(InequalityState& to) const { to.c = c, to.xi = xi, to.state = places.state; }
  void enter_states(); ///< linearises all graphs about the states that the points have
  void classify(double shrink = 1.0); ///< all points by their resolvents (GraphStates::classify)
  void update_arguments();            ///< z = G c + g

  const ContactPoints& points;
  Vector c, z, xi;
  GraphStates places;
  ForceBalance balance;
  Snap snap;
  Vector z_start; ///< where the path to the present place began
  /// No law acted where the last solve began: its first linear solve is that of the linear problem.
  bool idle = false;

private:
  void take_state(int p, int state);
};

} // namespace hvi::solver
