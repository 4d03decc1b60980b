// Steps under laws whose bounds are multipliers of others.
#pragma once

#include "solver/step/equation_solver.hpp"

namespace hvi::solver {

/// Coulomb's bound depends on the normal multiplier: a step that was solved with given bounds is
/// solved again with those of its own last solution while that contracts, else by Newton's method
/// with the bounds unknown, too. Leaves the graphs at the last solution's bounds, whether they
/// still move or not: the certificate judges all laws at one state. `path_start`: where each pass
/// begins its path, or null.
void couple_bounds(EquationSolver& solver, double tolerance, StepMatrix& matrix,
                   const InequalityState* path_start, StepEquation& equation, Trial& trial,
                   StepResult& out);

} // namespace hvi::solver
