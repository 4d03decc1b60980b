// Lipschitz constants of the rates of states.
#pragma once

#include "solver/common/bracket.hpp"
#include "solver/plan/problem.hpp"

namespace hvi::solver {

/// sup of the sum of |derivatives|: over all inputs (infinite where it grows without end or no
/// bound was found), and over inputs up to 1 in size. States vary in their ranges, where these are
/// infinite as inputs do.
struct RateConstant {
  Bracket everywhere, near;
};
struct RateConstants {
  RateConstant by_states, by_inputs;
  bool other_states = false; ///< the rate reads states besides its own
  bool reads_inputs = false; ///< values of the unknown, its rate, or multipliers
};
/// By branch and bound over at most six variables (largest.hpp), the place in the box of the mesh;
/// normals are the axes, more variables stay at 0: then the numbers are sampled.
RateConstants rate_constants(const Problem& problem, const Mesh& mesh, const StateTerm& state);

} // namespace hvi::solver
