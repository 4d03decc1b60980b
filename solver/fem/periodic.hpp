// Periodic parts: which degrees of freedom have one value.
#pragma once

#include "solver/fem/space.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// By dof the smallest one that has its value; empty where no part is periodic.
///
/// The second part of each PeriodicSpec is the first one moved by a translation, which is found
/// from the boxes around both. Nodes meet within 1e-7 of the size of the mesh, and facets meet
/// facets, so that the functions of V^h are periodic, not only their values at nodes. Throws
/// Failure(bad_value) where they do not, and where the translation of a body of
/// revolution changes the radius.
std::vector<std::int32_t> periodic_dofs(const Space& space, const SpaceSpec& spec,
                                        std::span<const Region> parts);

/// For people: the condition as scripts write it, and what it is on this mesh.
struct PeriodicNote {
  std::string condition; ///< "periodic.x `left` = `right`"; of several unknowns: " of `u`"
  std::string found;     ///< "moved by (1, 0); 5 nodes repeat others"
  Origin origin;
};
std::vector<PeriodicNote> periodic_notes(const Space& space, const Problem& problem,
                                         std::span<const Region> parts);

} // namespace hvi::solver
