// Cracks: inner facets along which a mesh is cut.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <span>

namespace hvi::solver {

/// Cuts the mesh along groups of inner facets: nodes on them are doubled where the cells around
/// come apart, so that the edge of a cut inside the body stays one, and its end on the boundary
/// opens. Each group becomes two: `crack.first`, its facets as they were, and `crack.second`, those
/// of the cells on the other side; a facet of which no node opens stays as it is, in neither.
/// Throws Failure(unknown_group) for a group that there is not, Failure(bad_mesh) for one of other
/// things than facets, with facets of the boundary, or with facets of a group cut before.
void split(Mesh& mesh, std::span<const std::string> groups);

} // namespace hvi::solver
