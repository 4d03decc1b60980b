// The unknowns and the fields of a report as arrays over the nodes of the space.
#pragma once

#include "lang/python/answer.hpp"
#include "solver/time/run.hpp"

namespace hvi::python {

Grid grid_of(const solver::Space& space);
/// Each unknown of a full vector: nodes x components, without the second index where there is one
/// component. An unknown in P1 beside others in P2 has its mean at the middle of an edge; an
/// unknown on a part of the mesh is NaN elsewhere.
std::vector<Array> unknowns_of(const solver::Space& space, const solver::Vector& u);
/// Adds every field of the report to the pictures of the plan, which keep its values at nodes:
/// multipliers and states at the points of laws have none. How many pictures there were before.
std::size_t show_fields(solver::Plan& plan);
/// What was kept of them.
std::vector<Array> shown_fields(const solver::Plan& plan, std::size_t first,
                                const solver::RunResult& result);

} // namespace hvi::python
