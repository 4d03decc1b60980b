// The conditions that a finished run must meet to be a result.
#pragma once

#include "solver/results/run_result.hpp"

namespace hvi::solver {

/// Throws Failure(mostly_rounding) for a result that is mostly rounding: its forward error is above
/// ForwardError::largest, or (with monitors) the work of the loads differs from the energies.
void refuse_rounding(const RunResult& result, const Problem& problem);

} // namespace hvi::solver
