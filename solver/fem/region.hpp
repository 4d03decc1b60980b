// From the small tree that names a part to the entities of a mesh.
#pragma once

#include "solver/mesh/mesh.hpp"
#include "solver/plan/problem.hpp"

#include <vector>

namespace hvi::solver {

/// Throws Failure with the origin of the mesh statement, whatever goes wrong.
Mesh make_mesh(const MeshSpec& spec);

/// What a condition leaves out, since only whole entities are selected.
struct CutEntities {
  int count = 0;     ///< entities of which a tenth or more is inside
  double lost = 0.0; ///< length, area or volume inside all that are cut, about
};

/// A resolved part.
struct Region {
  Group::Kind kind = Group::Kind::cells;
  std::vector<std::int32_t> entities; ///< cells, facets or nodes (for points), sorted, unique
  int straddling = 0;                 ///< entities a predicate cut in two (left out)
  /// Of a pair, whose `entities` are its first side: the second side, and RegionSpec::reach.
  std::vector<std::int32_t> second{};
  double reach = 0.0;
  CutEntities cut{}; ///< by the part's own condition
  bool is_pair() const { return !second.empty(); }
};

/// `where` keeps an entity when its centroid and its corners, each moved by 1e-6 towards the
/// centroid, satisfy the predicate. Throws Failure(unknown_group) naming the groups there are,
/// Failure(empty_region) for a part without entities, Failure(bad_value) for a union or difference
/// of different kinds, for a point that is no node (relative 1e-9), and for a predicate that is NaN
/// somewhere. The boundary is all boundary facets; facets inside are reached by their groups only.
Region resolve(const Mesh& mesh, const RegionSpec& spec);

/// The entities two regions share, sorted; none for regions of different kinds.
std::vector<std::int32_t> common(const Region& a, const Region& b);

/// Length, area or volume; of points 0.
double region_measure(const Mesh& mesh, const Region& region);

/// The nodes of a region's entities, sorted, unique.
std::vector<std::int32_t> nodes_of(const Mesh& mesh, const Region& region);

} // namespace hvi::solver
