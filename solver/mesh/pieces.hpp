// Several meshes put together in one: bodies side by side.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <span>

namespace hvi::solver {

/// The meshes as one, which share no node. Group `top` of the mesh named `upper` becomes
/// `upper.top`; new are `upper`, its cells, and `upper.boundary`, beside which a group
/// `boundary` of the mesh is `upper.group("boundary")`. The meshes have one dimension.
/// Throws Failure(bad_mesh) where two groups come to have one name, Failure(limit) beyond 50
/// million cells.
Mesh side_by_side(std::span<const Mesh> meshes, std::span<const std::string> names);

} // namespace hvi::solver
