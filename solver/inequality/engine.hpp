// The inequality solver's parts, and the order in which they are asked. Internal to
// solver/inequality.
//
//   ContactPoints    what is fixed about the points; StiffnessPattern: their H on its pattern
//   Position         where a search stands: c, z, xi, GraphStates, ForceBalance, Snap
//   LastFactor       the factor of S + H; ConjugateGradients around it does without a new one
//   KrylovTangent    the same by iterations, where the operator has no factor
//   ActiveSetNewton  Newton on graph states; solve_globally (fallback.hpp) where it fails
//   ComponentSearch  releases: from component to component of laws that jump down
//   KeptInverse      Newton by an updated inverse, for laws of straight pieces, from a guess
//   BranchFollower   the branch that continues the last state, the state of least energy
//   CoupledNewton    bounds that are other laws' multipliers; SharePath: as they grow from 0
#pragma once

#include "solver/inequality/conjugate_gradients.hpp"
#include "solver/inequality/follow.hpp"
#include "solver/inequality/inverse.hpp"
#include "solver/inequality/krylov_tangent.hpp"

namespace hvi::solver {

class CoupledBounds;

class InequalityEngine {
public:
  InequalityEngine(const ReducedProblem& problem, ReducedOperator& s, InequalityOptions options,
                   std::span<const double> factors);
  // As in InequalitySolver.
  InequalityReport solve(const Vector& r, InequalityState& io);
  InequalityReport solve_coupled(const Vector& r, InequalityState& io);
  bool convex() { return is_convex(points_, pattern_, factor_); }
  bool respond(const InequalityState& at_state, std::span<const Vector> r,
               std::vector<Vector>& change_c, std::vector<Vector>& change_xi);
  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  void solve_at_once(Methods methods, InequalityState& io, InequalityReport& report);
  void solve_and_follow(InequalityState& io, InequalityReport& report);
  void certify_found(InequalityReport& report, double snap = Snap::certificate);
  void search_coupled(const Vector& r, InequalityState& io, InequalityReport& report);
  void try_without_rounding(CoupledBounds& bounds, InequalityReport& report);

  const InequalityOptions options_;
  ContactPoints points_;
  StiffnessPattern pattern_;
  Position at_;
  LastFactor factor_;
  ConjugateGradients tangent_;
  KrylovTangent krylov_;
  ActiveSetNewton newton_;
  ComponentSearch components_;
  KeptInverse inverse_;
  BranchFollower follower_;
  // Room for a solve.
  StepStart start_;
  InequalityState before_;
};

} // namespace hvi::solver
