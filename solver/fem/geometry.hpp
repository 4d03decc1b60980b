// Straight-sided cells: gradients of the barycentric coordinates, points, facets inside cells.
#pragma once

#include "solver/fem/element.hpp"
#include "solver/fem/space.hpp"

namespace hvi::solver {

/// Affine map of one cell.
struct CellGeometry {
  double measure = 0.0;
  std::array<std::array<double, 3>, 4> gradient{}; ///< of lambda_k, k <= dim
  std::array<double, 4> radius{}; ///< x of the corners of an axisymmetric mesh, else 0
};
CellGeometry cell_geometry(const Mesh& mesh, int cell);

/// The point of a cell with these barycentric coordinates.
Point point_in_cell(const Mesh& mesh, int cell, const Barycentric& point);
/// The coordinates of a point in or near a cell.
Barycentric barycentric_in_cell(const Mesh& mesh, int cell, const Point& x);

/// Which local vertices of facets[facet].cell the facet's vertices are.
std::array<int, 3> facet_in_cell(const Mesh& mesh, int facet);

/// 2 pi x on axisymmetric meshes, where a point stands for its circle; else 1.
double circumference(const Mesh& mesh, double x);
/// Has the unknown a function at this node? In P1 beside others in P2: at vertices; on a part of
/// the mesh: at its nodes.
inline bool has_node(const Space& space, const SpaceBlock& block, int node) {
  if (block.domain && block.domain->has_node[static_cast<std::size_t>(node)] == 0) return false;
  return block.order == space.order || node < static_cast<int>(space.mesh->nodes.size());
}
/// Has the unknown the row `hoop`? Vectors on axisymmetric meshes.
inline bool has_hoop(const Space& space, const SpaceBlock& block) {
  return space.mesh->axisymmetric && block.components > 1;
}
/// Has any?
inline bool has_hoop(const Space& space) {
  for (const SpaceBlock& block : space.blocks)
    if (has_hoop(space, block)) return true;
  return false;
}
inline constexpr int hoop_row = 3;
/// Where the rows of P1 begin in the table of a space that is mixed.
inline constexpr int linear_rows = 4;

/// Shape functions of the space at one point of a cell: row 0 the values, row 1 + j the derivatives
/// d phi_i / d x_j; at(row, i) with i < size. Vectors on axisymmetric meshes have phi_i / x in row
/// hoop_row: on the axis, where functions of V vanish, its limit d phi_i / d x. Mixed spaces have
/// the same of P1 in the rows from linear_rows on, zero for nodes of edges.
struct ShapeTable {
  int size = 0, rows = 1;
  std::array<double, 2 * linear_rows * max_cell_nodes> data{};
  double* row(int r) { return data.data() + r * max_cell_nodes; }
  const double* row(int r) const { return data.data() + r * max_cell_nodes; }
  double at(int r, int i) const { return row(r)[i]; }
};
/// Fills `shapes`; without `gradients` row 0 only.
void evaluate_shapes(const Space& space, const CellGeometry& geometry, const Barycentric& point,
                     bool gradients, ShapeTable& shapes);

/// Row of a ShapeTable and component, among those of all unknowns, of a derivative index
/// (slot::value, slot::gradient, slot::of_unknown).
struct Derivative {
  int component, row;
};
/// Throws Failure(bad_value) for an index that a space of these dimensions does not have.
Derivative decode(const Space& space, int index, Origin origin);

} // namespace hvi::solver
