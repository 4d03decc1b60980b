// The operators of a problem whose matrices several processes assemble, each on its own cells.
#pragma once

#include "solver/discrete/operators.hpp"

namespace hvi::solver {

/// Can they? Where no mass is taken off the contact, no states change a form and none acts across a
/// pair. Others are assembled by the first process.
bool may_be_dealt(const Problem& problem, const Discretisation& discretisation);

/// Of such a problem. `processes`: two or more, which are led (processes.hpp).
Operators deal_operators(const Problem& problem, const Discretisation& discretisation,
                         const StateLayout& layout, int processes);

} // namespace hvi::solver
