// Parts of axisymmetric meshes over which nothing can be integrated; called by discretise.
#pragma once

#include "solver/fem/region.hpp"
#include "solver/plan/plan.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// Failure(empty_region) for every integral of the plan (form, law, load, state, probe) over facets
/// that all lie on the axis: they have no area, and the integral would be zero without a word.
std::vector<Failure> integrals_on_axis(const Plan& plan, const Mesh& mesh,
                                       std::span<const Region> parts);

} // namespace hvi::solver
