// The operators of a problem whose matrices several processes assemble, each on its own cells.
#pragma once

#include "solver/discrete/operators.hpp"
#include "solver/discrete/own_matrices.hpp"

namespace hvi::solver {

/// What all processes are to assemble.
DealtForms forms_to_deal(const Problem& problem, const Discretisation& discretisation,
                         const StateLayout& layout);

/// As assemble_operators makes them, without equal values. `processes`: two or more, which are led
/// (processes.hpp).
Operators deal_operators(const Problem& problem, const Discretisation& discretisation,
                         const StateLayout& layout, int processes);

} // namespace hvi::solver
