// How a run begins where another problem has ended: from a state of equilibrium.
#pragma once

#include "solver/time/run_state.hpp"

namespace hvi::solver {

/// The plan with its start solved: without Plan::start, and with the last state of that.
Plan with_start_solved(const Plan& plan, const Discretisation& discretisation,
                       const RunSettings& settings, std::vector<StepNote>& notes);

/// Gives the laws the multipliers of TimeSpec::start. Laws that the start did not know (those on
/// rates or memories) exert no force there: throws Failure(bad_value) for one that would.
void take_start(const Problem& problem, RunState& run);

} // namespace hvi::solver
