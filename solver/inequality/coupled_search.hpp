// The order of methods for laws whose bounds are other laws' multipliers (coupled.hpp): Newton's
// method from the last state, then laws without bounds, which are raised.
#pragma once

#include "solver/inequality/engine_parts.hpp"

namespace hvi::solver {

/// As InequalitySolver::solve_coupled, from a right-hand side of the right size; the factor is
/// forgotten. `start`: room.
void solve_coupled(EngineParts& parts, const Vector& r, StepStart& start, InequalityState& io,
                   InequalityReport& report);

} // namespace hvi::solver
