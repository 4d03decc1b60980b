// The parts of the inequality solver, in the order in which they are asked. Internal to
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
#pragma once

#include "solver/inequality/conjugate_gradients.hpp"
#include "solver/inequality/follow.hpp"
#include "solver/inequality/inverse.hpp"
#include "solver/inequality/krylov_tangent.hpp"

namespace hvi::solver {

struct EngineParts {
  EngineParts(const ReducedProblem& problem, ReducedOperator& s, InequalityOptions options_given,
              std::span<const double> factors);

  const InequalityOptions options;
  ContactPoints points;
  StiffnessPattern pattern;
  Position at;
  LastFactor factor;
  ConjugateGradients tangent;
  KrylovTangent krylov;
  ActiveSetNewton newton;
  ComponentSearch components;
  KeptInverse inverse;
  BranchFollower follower;
};

/// The certificate of what was found, with what nothing acts on at rest.
void certify_found(EngineParts& parts, InequalityReport& report, double snap = Snap::certificate);

} // namespace hvi::solver
