// What laws exert when a run begins in a state of equilibrium.
#pragma once

#include "solver/step/run_state.hpp"

namespace hvi::solver {

/// Gives the laws the multipliers of TimeSpec::start. Laws that the start did not know (those on
/// rates or memories) exert no force there: throws Failure(bad_value) for one that would.
void take_start(const Problem& problem, RunState& run);

} // namespace hvi::solver
