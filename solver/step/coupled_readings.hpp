// Steps under laws that read the solution: other unknowns, rates, memories, multipliers.
#pragma once

#include "solver/step/equation_solver.hpp"

#include <functional>

namespace hvi::solver {

/// A law that reads u_n, w_m(t_n) = h_m + w0_m u_n or a multiplier depends on the step's own
/// solution: a step that was solved with given readings (`out`) is solved again with those of its
/// own last solution, until the laws with the readings of a solution hold in it. For memories that
/// contracts with the length of the step; Anderson's mixing finds the readings where it does not.
/// Leaves the graphs at the readings of the last solution, whether they still move or not: the
/// certificate judges all laws at one state. `path_start`: where each pass begins its path, or
/// null. `solve`: the step with given readings.
void couple_readings(StepLaws& laws, Contact& contact, double tolerance,
                     const InequalityState* path_start, const StepEquation& equation, Trial& trial,
                     const std::function<StepResult(CorrectionStart)>& solve, StepResult& out);

} // namespace hvi::solver
