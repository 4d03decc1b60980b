// Steps of bodies that laws alone hold, and whose laws let go under more than they can bear.
#pragma once

#include "solver/step/equation_solver.hpp"

namespace hvi::solver {

/// Under the whole load of a step the search for a solution may come to where glue has torn and
/// nothing holds the body, though there is a state in which it does. Where `out` says so (it does
/// not balance a part of the load that can be seen), the load is put on in parts, from that which
/// the multipliers of `start` balanced; each part begins where the last one ended, and is halved
/// until it holds, or until it is too small. `out` and the trial are as they were where it fails.
void put_load_on_in_parts(EquationSolver& solver, const Contact& contact, Balance& balance,
                          StepMatrix& matrix, const InequalityState& start, StepEquation& equation,
                          Trial& trial, StepResult& out);

} // namespace hvi::solver
