// Parts that may not share entities: a law or a load on a clamped facet, a law twice on a part.
#pragma once

#include "solver/fem/region.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// Failure(overlapping_regions) for each law or load term that acts on a facet (2D: edge, 3D: face)
/// on which all the components it acts on are imposed, and for each law stated twice on an entity.
/// A shared node is normal: two parts of a boundary meet.
std::vector<Failure> overlaps(const Problem& problem, const Mesh& mesh,
                              std::span<const Region> parts);

} // namespace hvi::solver
