// Lipschitz constants of the rates of states, and of laws in what they read.
#pragma once

#include "solver/hypotheses/variation.hpp"
#include "solver/plan/problem.hpp"

namespace hvi::solver {

/// Of one rate. States vary in their ranges, where these are infinite as inputs do; the place
/// varies in the box of the mesh.
struct RateConstants {
  Variation by_states, by_inputs;
  bool other_states = false; ///< the rate reads states besides its own
  bool reads_inputs = false; ///< values of the unknown, its rate, or multipliers
};
RateConstants rate_constants(const Problem& problem, const Mesh& mesh, const StateTerm& state);

/// Of the force of one law: by the states in its superpotential and in what stands beside the
/// unknown in its argument, and by what it reads of the solution or of another law. `lipschitz`: of
/// its slope, for given states.
struct SlopeConstants {
  Variation by_states, by_readings;
  bool reads_states = false, reads = false;
};
SlopeConstants slope_constants(const Problem& problem, const Mesh& mesh, const LawTerm& term,
                               double lipschitz);

} // namespace hvi::solver
