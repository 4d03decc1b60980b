// What iterative solvers are told of the unknowns of a run.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/state.hpp"
#include "solver/linear/iterative_solver.hpp"

#include <memory>

namespace hvi::solver {

/// Nodes, components and rigid motions of the unknowns.
std::shared_ptr<UnknownsOfNodes> nodes_of_unknowns(const Discretisation& discretisation,
                                                   const StateLayout& layout);

} // namespace hvi::solver
