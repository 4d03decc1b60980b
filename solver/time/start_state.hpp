// How a run begins where another problem has ended: from a state of equilibrium.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/run_settings.hpp"

namespace hvi::solver {

/// The plan with its start solved: without Plan::start, and with the last state of that.
Plan with_start_solved(const Plan& plan, const Discretisation& discretisation,
                       const RunSettings& settings, std::vector<StepNote>& notes);

} // namespace hvi::solver
