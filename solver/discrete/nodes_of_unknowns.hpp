// What iterative solvers are told of the unknowns of a run.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/state.hpp"
#include "solver/linear/iterative_solver.hpp"

#include <string>

namespace hvi::solver {

/// Nodes, components and rigid motions of the unknowns. Throws Failure(bad_value) where there are
/// several unknown fields, for which there is no iterative solver.
std::shared_ptr<const UnknownsOfNodes> nodes_of_unknowns(const Problem& problem,
                                                         const Discretisation& discretisation,
                                                         const StateLayout& layout);

/// Why a problem cannot be solved by iterations at all; empty: it can.
std::string obstacle_to_iterations(const Discretisation& discretisation);

} // namespace hvi::solver
