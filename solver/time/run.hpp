// The run: from a plan to certified steps. What the language's driver and a C++ user call.
#pragma once

#include "solver/plan/plan.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/run_settings.hpp"
#include "solver/time/discretise.hpp"

namespace hvi::solver {

/// Solves. Throws Failure(not_certified) at a step without certificate, with its number in the
/// message and the law's origin; what was computed up to the last good step is in `partial`.
/// Tables reach the disk meanwhile: a killed run leaves all rows but those of its last second.
RunResult run(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings,
              RunResult* partial = nullptr);

} // namespace hvi::solver
