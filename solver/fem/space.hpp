// Finite element spaces: P1 and P2 on simplices, scalar or vector, with eliminated values.
#pragma once

#include "solver/common/failure.hpp"
#include "solver/fem/region.hpp"
#include "solver/linear/sparse.hpp"
#include "solver/mesh/mesh.hpp"
#include "solver/plan/plan.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

/// V^h before boundary values. Nodes: the mesh's, then for P2 one per edge.
/// dof = node * components + component.
struct Space {
  const Mesh* mesh = nullptr;
  int order = 1;
  int components = 1;
  std::vector<Point> nodes;
  int nodes_per_cell = 3, nodes_per_facet = 2;
  std::vector<std::int32_t> cell_nodes;  ///< n_cells x nodes_per_cell, vertices first, then edges
  std::vector<std::int32_t> facet_nodes; ///< n_facets x nodes_per_facet, the same order

  int n_dofs() const { return static_cast<int>(nodes.size()) * components; }
  int dof(int node, int component) const { return node * components + component; }
};
Space make_space(const Mesh& mesh, int order, int components);
/// Nodes of the space on a region (P2: edge nodes too), sorted, unique.
std::vector<std::int32_t> nodes_on(const Space& space, const Region& region);

/// One eliminated degree of freedom: its value is values[expression](x(node), t).
struct Eliminated {
  std::int32_t dof;
  std::int32_t dirichlet; ///< index into SpaceSpec::dirichlet
  std::int32_t value;     ///< which of its value expressions; -1: zero
};

/// Free and eliminated degrees of freedom. Values imposed twice on one dof must be the same
/// expressions, else Failure(overlapping_regions).
struct DofMap {
  std::vector<std::int32_t> free;       ///< dof of each unknown
  std::vector<std::int32_t> unknown_of; ///< unknown of each dof, -1 when eliminated
  std::vector<Eliminated> eliminated;
  bool homogeneous = true;              ///< every eliminated value is zero at all times
  int n_unknowns() const { return static_cast<int>(free.size()); }
};
DofMap make_dof_map(const Space& space, const SpaceSpec& spec, std::span<const Region> parts);
/// Sets the eliminated entries of the full vector u at time t. Throws Failure(bad_value) at NaN.
void impose(const Space& space, const SpaceSpec& spec, const DofMap& map, double t, Vector& u);

/// Interpolates expressions of slot::x (one per component) at the nodes.
Vector interpolate(const Space& space, std::span<const Expr> components, double t, Origin origin);

} // namespace hvi::solver
