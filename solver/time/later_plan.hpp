// The plan of a run whose numbers change between two steps.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"

namespace hvi::solver {

/// Throws Failure(bad_value), which says why, where a run of `now` cannot go on as one of `next`:
/// mesh, unknowns, times, what is behind it (initial values, the kernels of its memories) and the
/// shape of laws, states and tables have to be the same. Coefficients of forms, loads, imposed
/// values, laws and rates of states may differ.
void require_same_evolution(const Plan& now, const Plan& next,
                            const Discretisation& discretisation);

/// Can a run of `now` take over loads and imposed values of `next`, and all else stays?
bool only_loads_differ(const Plan& now, const Plan& next);
/// It does: nothing else of the problem moves, not in memory either.
void take_loads_of(const Plan& next, Problem& problem);

} // namespace hvi::solver
