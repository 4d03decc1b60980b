// The plan of a run whose numbers change between two steps.
#pragma once

#include "solver/time/run.hpp"

namespace hvi::solver {

/// Throws Failure(bad_value), which says why, where a run of `now` cannot go on as one of `next`:
/// mesh, unknowns, times, what is behind it (initial values, the kernels of its memories) and the
/// shape of laws, states and tables have to be the same. Coefficients of forms, loads, imposed
/// values, laws and rates of states may differ.
void require_same_evolution(const Plan& now, const Plan& next,
                            const Discretisation& discretisation);

} // namespace hvi::solver
