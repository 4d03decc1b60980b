// Measures, normals and quality of a mesh.
#include "solver/mesh/mesh.hpp"

#include "solver/common/triples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

/// Outward normal times the measure of the facet.
Point scaled_normal(const Mesh& mesh, const Facet& facet) {
  const Point& a = mesh.nodes[facet.nodes[0]];
  if (mesh.dim == 1) return {facet.nodes[0] == mesh.cells[facet.cell][1] ? 1.0 : -1.0, 0, 0};
  const Point ab = minus(mesh.nodes[facet.nodes[1]], a);
  if (mesh.dim == 2) return {ab[1], -ab[0], 0};
  const Point n = cross(ab, minus(mesh.nodes[facet.nodes[2]], a));
  return {n[0] / 2, n[1] / 2, n[2] / 2};
}

struct CellShape {
  double shortest, longest;
  double aspect; ///< longest edge / (inscribed diameter * its value for the regular simplex)
};

/// Inscribed radius r = dim * measure / (measure of the cell's surface); the regular triangle has
/// longest edge / 2r = sqrt 3, the regular tetrahedron sqrt 6.
CellShape shape_of(const Mesh& mesh, int cell, double measure) {
  const auto& c = mesh.cells[cell];
  CellShape shape{std::numeric_limits<double>::infinity(), 0, 1};
  double perimeter = 0;
  for (int i = 0; i <= mesh.dim; ++i) {
    for (int j = i + 1; j <= mesh.dim; ++j) {
      const double edge = norm(minus(mesh.nodes[c[j]], mesh.nodes[c[i]]));
      shape.shortest = std::min(shape.shortest, edge);
      shape.longest = std::max(shape.longest, edge);
      perimeter += edge;
    }
  }
  if (mesh.dim == 2) shape.aspect = shape.longest * perimeter / (4 * measure * std::sqrt(3.0));
  if (mesh.dim == 3) {
    double surface = 0;
    for (int i = 0; i < 4; ++i) {
      const Point& a = mesh.nodes[c[i]];
      surface +=
          norm(cross(minus(mesh.nodes[c[(i + 1) % 4]], a), minus(mesh.nodes[c[(i + 2) % 4]], a))) /
          2;
    }
    shape.aspect = shape.longest * surface / (6 * measure * std::sqrt(6.0));
  }
  return shape;
}

} // namespace

int Mesh::piece_of_cell(std::int32_t cell) const {
  const auto next = std::upper_bound(pieces.begin(), pieces.end(), cell);
  return std::max(static_cast<int>(next - pieces.begin()) - 1, 0);
}

double cell_measure(const Mesh& mesh, int cell) {
  const auto& c = mesh.cells[cell];
  const Point& a = mesh.nodes[c[0]];
  const Point ab = minus(mesh.nodes[c[1]], a);
  if (mesh.dim == 1) return ab[0];
  const Point ac = minus(mesh.nodes[c[2]], a);
  if (mesh.dim == 2) return (ab[0] * ac[1] - ab[1] * ac[0]) / 2;
  return dot(cross(ab, ac), minus(mesh.nodes[c[3]], a)) / 6;
}

double facet_measure(const Mesh& mesh, int facet) {
  return norm(scaled_normal(mesh, mesh.facets[facet]));
}

Point facet_normal(const Mesh& mesh, int facet) {
  Point n = scaled_normal(mesh, mesh.facets[facet]);
  const double length = norm(n);
  for (double& x : n) x /= length;
  return n;
}

double Box::diagonal() const { return norm(minus(high, low)); }

Box bounding_box(const Mesh& mesh) {
  if (mesh.nodes.empty()) return {};
  Box box{mesh.nodes.front(), mesh.nodes.front()};
  for (const Point& p : mesh.nodes) {
    for (int i = 0; i < 3; ++i) {
      box.low[i] = std::min(box.low[i], p[i]);
      box.high[i] = std::max(box.high[i], p[i]);
    }
  }
  return box;
}

MeshQuality mesh_quality(const Mesh& mesh) {
  MeshQuality q{std::numeric_limits<double>::infinity(), 0, 0, 1, 0, 0};
  for (std::size_t i = 0; i < mesh.cells.size(); ++i) {
    const int cell = static_cast<int>(i);
    const double measure = cell_measure(mesh, cell);
    const CellShape shape = shape_of(mesh, cell, measure);
    q.measure += measure;
    q.shortest_edge = std::min(q.shortest_edge, shape.shortest);
    q.longest_edge = std::max(q.longest_edge, shape.longest);
    q.worst_aspect = std::max(q.worst_aspect, shape.aspect);
  }
  q.h = q.longest_edge; // the diameter of a simplex is its longest edge
  const auto piece = pieces_of(mesh);
  if (!piece.empty()) q.pieces = 1 + *std::max_element(piece.begin(), piece.end());
  return q;
}

} // namespace hvi::solver
