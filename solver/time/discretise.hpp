// From a plan to its mesh, parts and space, or to all that is wrong with them.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"

#include <atomic>
#include <vector>

namespace hvi::solver {

/// All mesh and part mistakes of the plan at once (several missing groups: several failures).
/// Includes: unknown groups, empty parts, a law or load on a clamped facet, a law twice on a part,
/// a point that is no node, an initial state that contradicts the imposed values.
/// A mesh that is adapted is solved on meanwhile, until `stop`: throws Failure(interrupted).
std::vector<Failure> discretise(const Plan& plan, Discretisation& out,
                                const std::atomic<bool>* stop = nullptr);
/// The same on a given mesh, which must have the groups the plan's mesh has.
std::vector<Failure> discretise_on(const Plan& plan, Mesh mesh, Discretisation& out);

} // namespace hvi::solver
