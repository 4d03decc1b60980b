// Finite element spaces: P1 and P2 on simplices, scalar or vector, with eliminated values.
#pragma once

#include "solver/common/failure.hpp"
#include "solver/fem/region.hpp"
#include "solver/linear/sparse.hpp"
#include "solver/mesh/mesh.hpp"
#include "solver/plan/problem.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// Which nodes share an element, as sorted rows: neighbours of i are
/// neighbours[offsets[i] .. offsets[i + 1]), i itself included when it is in an element.
struct NodeGraph {
  std::vector<std::int32_t> offsets, neighbours;
};
/// `element_nodes`: elements x nodes_per_element.
NodeGraph make_node_graph(std::size_t n_nodes, std::span<const std::int32_t> element_nodes,
                          int nodes_per_element);

/// What slot::inside(p) reads: which entities belong to part p of the plan.
struct PartIndicators {
  struct Part {
    Group::Kind kind = Group::Kind::cells;
    std::vector<std::uint8_t> inside; ///< by entity of that kind
  };
  std::vector<Part> parts;
  /// 1 or 0. A facet asks for itself, then for the cell behind it; a node likewise.
  double value(int part, Group::Kind kind, int entity, int cell) const;
};
std::shared_ptr<const PartIndicators> make_indicators(const Mesh& mesh,
                                                      std::span<const Region> parts);

/// Where an unknown lives that has functions on a part of the mesh only.
struct SpaceDomain {
  int part = 0; ///< of the plan
  Region cells;
  std::vector<std::uint8_t> has_cell, has_node; ///< by cell, by node of the space
};

/// The functions of one unknown in a product of spaces.
struct SpaceBlock {
  std::string name = "u"; ///< of the unknown
  int first = 0;          ///< of its components among all
  int components = 1;
  int order = 1;
  std::shared_ptr<const SpaceDomain> domain{}; ///< null: the whole mesh
  bool lives_in(int cell) const {
    return domain == nullptr || domain->has_cell[static_cast<std::size_t>(cell)] != 0;
  }
};

/// V^h before boundary values, or a product of several. Nodes: the mesh's, then for P2 one per
/// edge. dof = node * components + component, the components of all unknowns one behind the other.
/// An unknown in P1 beside others in P2 has no functions at the edges' nodes: its dofs there are
/// eliminated, and zero. So are those of an unknown on a part of the mesh at all other nodes.
struct Space {
  const Mesh* mesh = nullptr;
  int order = 1; ///< the highest of the unknowns
  int components = 1;
  std::vector<SpaceBlock> blocks{SpaceBlock{}};
  std::vector<Point> nodes;
  int nodes_per_cell = 3, nodes_per_facet = 2;
  std::vector<std::int32_t> cell_nodes;  ///< n_cells x nodes_per_cell, vertices first, then edges
  std::vector<std::int32_t> facet_nodes; ///< n_facets x nodes_per_facet, the same order
  /// Of the cells; all cell forms have its pattern. Shared: copies of a space are cheap to keep.
  std::shared_ptr<const NodeGraph> graph;
  std::shared_ptr<const PartIndicators> indicators; ///< for slot::inside; may be empty

  int n_dofs() const { return static_cast<int>(nodes.size()) * components; }
  int dof(int node, int component) const { return node * components + component; }
  bool is_product() const { return blocks.size() > 1; }
  bool is_mixed() const; ///< are there unknowns in P1 beside others in P2?
  int block_of(int component) const;
  std::span<const std::int32_t> nodes_of_cell(int cell) const {
    return {cell_nodes.data() + static_cast<std::size_t>(cell) * nodes_per_cell,
            static_cast<std::size_t>(nodes_per_cell)};
  }
  std::span<const std::int32_t> nodes_of_facet(int facet) const {
    return {facet_nodes.data() + static_cast<std::size_t>(facet) * nodes_per_facet,
            static_cast<std::size_t>(nodes_per_facet)};
  }
};
/// Of these cells.
std::shared_ptr<const SpaceDomain> domain_of_cells(const Space& space, Region cells, int part);
/// The cells an unknown has functions on.
Region cells_of(const Space& space, const SpaceBlock& block);
inline int n_unknowns(const Space& space) { return static_cast<int>(space.blocks.size()); }
/// Edges of a cell or facet come in the order of simplex_edges (element.hpp). `mesh` must outlive
/// the space. Throws std::invalid_argument for an order that is not 1 or 2.
/// `parts`: of the plan, for expressions with slot::inside.
Space make_space(const Mesh& mesh, int order, int components, std::span<const Region> parts = {});
/// Of a plan, for all its unknowns.
Space make_space(const Mesh& mesh, const SpaceSpec& spec, std::span<const Region> parts = {});
/// Nodes of the space on a region (P2: edge nodes too), sorted, unique.
std::vector<std::int32_t> nodes_on(const Space& space, const Region& region);
/// For messages: "u_y at node (0.5, 1)", for a scalar space "u at node (0.5, 1)".
std::string describe_dof(const Space& space, int dof);
/// "(0.5, 1)": as many coordinates as the mesh has dimensions.
std::string describe_point(const Point& point, int dim);

/// One eliminated degree of freedom: its value is values[expression](x(node), t).
struct Eliminated {
  std::int32_t dof;
  std::int32_t dirichlet; ///< index into SpaceSpec::dirichlet; -1: u_x on the axis
  std::int32_t value;     ///< which of its value expressions; -1: zero
  std::int32_t node;      ///< where that is imposed: its own, or the one it repeats (DofLink)
};

/// A degree of freedom of a periodic part: it has the value of another one.
struct DofLink {
  std::int32_t dof, to;
};

/// Free and eliminated degrees of freedom. On one part and component an entry with a value wins
/// over one without (the statement fills in what the space left at zero). Otherwise values imposed
/// twice on one dof must be the same expressions, or agree at the node at several sample times;
/// else Failure(overlapping_regions). On axisymmetric meshes u_x of vectors is 0 on the axis.
/// What is imposed at a node of a periodic part is imposed at those that repeat it, too.
struct DofMap {
  std::vector<std::int32_t> free;       ///< dof of each unknown
  std::vector<std::int32_t> unknown_of; ///< unknown of each dof, -1 when eliminated
  std::vector<Eliminated> eliminated;
  /// By dof. `to` is free, and no link's `dof`; unknown_of is the same for both.
  std::vector<DofLink> links;
  bool homogeneous = true; ///< every eliminated value is zero at all times
  /// By unknown: some value is imposed that a rigid motion does not have by itself.
  std::vector<char> held_of;
  bool held() const { return std::ranges::find(held_of, 0) == held_of.end(); }
  /// By unknown: the seminorm of strains or gradients alone is no norm.
  std::vector<char> needs_mass() const;
  int n_unknowns() const { return static_cast<int>(free.size()); }
};
DofMap make_dof_map(const Space& space, const SpaceSpec& spec, std::span<const Region> parts);
/// Sets the eliminated entries of the full vector u at time t. Throws Failure(bad_value) at NaN.
void impose(const Space& space, const SpaceSpec& spec, const DofMap& map, double t, Vector& u);

/// Interpolates expressions of slot::x (one per component) at the nodes.
Vector interpolate(const Space& space, std::span<const Expr> components, double t, Origin origin);

} // namespace hvi::solver
