// Steps of laws that read states, with the states of the same time.
#pragma once

#include "solver/step/body_tangent.hpp"
#include "solver/step/equation_solver.hpp"

#include <functional>

namespace hvi::solver {

/// After a solution with the states of the last step: states and solution are changed in turn, by
/// plain passes while these contract, by Newton's method with the states eliminated
/// (state_tangent.hpp), on a path of steps that grow to the full one, and, where that ends, by
/// marching on where the states lead (out.not_followed), until the states are those of their own
/// solution. Where states change forms or loads, too, Newton's method is that of `body`
/// (body_tangent.hpp), and Anderson's mixing (mixing.hpp) and passes that follow the states take
/// the place of the march. Leaves the laws prepared for the last states; where they do not settle,
/// `out` has no convergence and a verdict that names the state. `path_start`: where each pass
/// begins its path, or null; `renew`: makes the equation that of contact.state_values, and returns
/// what the increment leaves of it.
void couple_states(const Problem& problem, EquationSolver& solver, Contact& contact,
                   double tolerance, StepMatrix& matrix, const InequalityState* path_start,
                   BodyTangent* body, const std::function<double()>& renew, StepEquation& equation,
                   Trial& trial, StepResult& out);

/// Refinement of a solution moves what states at the points of laws read, by what rounding had left
/// of it: where a state is small this is much of it. Those that follow from the refined solution
/// are taken if it holds with them.
void follow_refined(EquationSolver& solver, Contact& contact, double tolerance,
                    const StepEquation& equation, const Trial& trial);

} // namespace hvi::solver
