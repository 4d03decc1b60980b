// Uniform refinement: red refinement of triangles, Bey's refinement of tetrahedra.
//
// R. E. Bank, A. H. Sherman, A. Weiser, Refinement algorithms and data structures for regular local
// mesh refinement, in: Scientific Computing, 1983: a triangle is cut into four by the midpoints of
// its edges.
//
// J. Bey, Tetrahedral grid refinement, Computing 55 (1995): with the nodes of a tetrahedron in path
// order x0 x1 x2 x3 the octahedron left in its middle is cut along x02-x13, and the children listed
// in path order again produce at most three shapes, however often one refines. Half of all path
// orders are negatively oriented, while our cells are positive, so the path order is coded:
// nodes[0] < nodes[3] says the cell is in path order, nodes[0] > nodes[3] that the middle two are
// swapped. The code is complete, since a path and its reverse refine alike.
#include "solver/common/failure.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/mesh/limits.hpp"

#include <algorithm>
#include <limits>

namespace hvi::solver {
namespace {

using Cell = std::array<std::int32_t, 4>;

/// All edges of a mesh, sorted; the midpoint of edge i becomes node first_midpoint + i.
class Midpoints {
public:
  explicit Midpoints(const Mesh& mesh) : nodes_(static_cast<std::int32_t>(mesh.nodes.size())) {
    edges_.reserve(mesh.cells.size() * (mesh.dim == 3 ? 6 : 3));
    for (const auto& c : mesh.cells)
      for (int i = 0; i <= mesh.dim; ++i)
        for (int j = i + 1; j <= mesh.dim; ++j) edges_.push_back(key(c[i], c[j]));
    std::sort(edges_.begin(), edges_.end());
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  }

  std::int32_t operator()(std::int32_t a, std::int32_t b) const {
    const auto at = std::lower_bound(edges_.begin(), edges_.end(), key(a, b));
    return nodes_ + static_cast<std::int32_t>(at - edges_.begin());
  }

  void add_nodes(const std::vector<Point>& old, std::vector<Point>& nodes) const {
    nodes.reserve(old.size() + edges_.size());
    nodes = old;
    for (const std::uint64_t e : edges_) {
      const Point &a = old[e >> 32], &b = old[e & 0xffffffffU];
      nodes.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
    }
  }

private:
  static std::uint64_t key(std::int32_t a, std::int32_t b) {
    const auto low = static_cast<std::uint64_t>(std::min(a, b));
    return low << 32 | static_cast<std::uint64_t>(std::max(a, b));
  }
  std::int32_t nodes_;
  std::vector<std::uint64_t> edges_;
};

Cell path_order(Cell c) {
  if (c[0] > c[3]) std::swap(c[1], c[2]);
  return c;
}

/// Stores a path as a positive cell; `positive`: the path itself is positively oriented.
Cell coded(Cell path, bool positive) {
  if ((path[0] < path[3]) != positive) path = {path[3], path[2], path[1], path[0]};
  if (!positive) std::swap(path[1], path[2]);
  return path;
}

void refine_tetrahedron(const Cell& cell, const Midpoints& mid, std::vector<Cell>& out) {
  const Cell x = path_order(cell);
  const bool positive = cell[0] < cell[3];
  const auto x01 = mid(x[0], x[1]), x02 = mid(x[0], x[2]), x03 = mid(x[0], x[3]);
  const auto x12 = mid(x[1], x[2]), x13 = mid(x[1], x[3]), x23 = mid(x[2], x[3]);
  // Bey's eight paths. Corner children are copies of the parent; of the inner four, the second and
  // fourth have the other orientation.
  out.push_back(coded({x[0], x01, x02, x03}, positive));
  out.push_back(coded({x01, x[1], x12, x13}, positive));
  out.push_back(coded({x02, x12, x[2], x23}, positive));
  out.push_back(coded({x03, x13, x23, x[3]}, positive));
  out.push_back(coded({x01, x02, x03, x13}, positive));
  out.push_back(coded({x01, x02, x12, x13}, !positive));
  out.push_back(coded({x02, x03, x13, x23}, positive));
  out.push_back(coded({x02, x12, x13, x23}, !positive));
}

std::array<Cell, 4> refine_triangle(const Cell& c, const Midpoints& mid) {
  const auto m01 = mid(c[0], c[1]), m12 = mid(c[1], c[2]), m02 = mid(c[0], c[2]);
  return {{{c[0], m01, m02, -1}, {m01, c[1], m12, -1}, {m02, m12, c[2], -1}, {m01, m12, m02, -1}}};
}

std::vector<Cell> refine_cells(const Mesh& mesh, const Midpoints& mid) {
  std::vector<Cell> cells;
  cells.reserve(mesh.cells.size() << mesh.dim);
  for (const auto& c : mesh.cells) {
    if (mesh.dim == 1) {
      const auto m = mid(c[0], c[1]);
      cells.push_back({c[0], m, -1, -1});
      cells.push_back({m, c[1], -1, -1});
    } else if (mesh.dim == 2) {
      for (const Cell& child : refine_triangle(c, mid)) cells.push_back(child);
    } else {
      refine_tetrahedron(c, mid, cells);
    }
  }
  return cells;
}

/// Children of a facet, in the orientation of the facet.
void refine_facet(int dim, const Facet& facet, const Midpoints& mid,
                  std::vector<std::array<std::int32_t, 3>>& out) {
  const auto& n = facet.nodes;
  if (dim == 1) out.push_back(n);
  if (dim == 2) {
    const auto m = mid(n[0], n[1]);
    out.push_back({n[0], m, -1});
    out.push_back({m, n[1], -1});
  }
  if (dim == 3) {
    for (const auto& t : refine_triangle({n[0], n[1], n[2], -1}, mid))
      out.push_back({t[0], t[1], t[2]});
  }
}

Group refine_cell_group(const Group& group, int dim) {
  Group fine{group.kind, {}};
  const std::int32_t children = 1 << dim;
  for (const std::int32_t e : group.entities)
    for (std::int32_t i = 0; i < children; ++i) fine.entities.push_back(e * children + i);
  return fine;
}

/// Square of the distance between the midpoints of the edges ac and bd, times 4.
double diagonal(const Point& a, const Point& b, const Point& c, const Point& d) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double x = a[i] + c[i] - b[i] - d[i];
    sum += x * x;
  }
  return sum;
}

bool is_positive(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto r = [&](const Point& p, int i) { return p[i] - a[i]; };
  double det = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    det += r(b, i) * (r(c, j) * r(d, k) - r(c, k) * r(d, j));
  }
  return det > 0;
}

} // namespace

Cell refinable_order(const std::vector<Point>& nodes, const Cell& c) {
  const std::array<Cell, 3> paths{
      {{c[0], c[1], c[2], c[3]}, {c[0], c[2], c[1], c[3]}, {c[0], c[1], c[3], c[2]}}};
  const auto length = [&](const Cell& p) {
    return diagonal(nodes[p[0]], nodes[p[1]], nodes[p[2]], nodes[p[3]]);
  };
  // A tie goes to the first, rounding or not: a mesh is the same from an ascii and a binary file.
  Cell best = paths[0];
  for (const Cell& path : paths)
    if (length(path) < (1 - 1e-9) * length(best)) best = path;
  return coded(best, is_positive(nodes[best[0]], nodes[best[1]], nodes[best[2]], nodes[best[3]]));
}

Mesh refine(const Mesh& mesh) {
  check_cell_limit(static_cast<double>(mesh.cells.size()) * (1 << mesh.dim));
  const Midpoints mid(mesh);
  Mesh fine;
  fine.dim = mesh.dim;
  fine.axisymmetric = mesh.axisymmetric;
  mid.add_nodes(mesh.nodes, fine.nodes);
  fine.cells = refine_cells(mesh, mid);
  for (const auto first : mesh.pieces) fine.pieces.push_back(first << mesh.dim);
  fine.description = mesh.description + ", refined";

  const int children = 1 << (mesh.dim - 1);
  std::vector<std::array<std::int32_t, 3>> named;
  named.reserve(mesh.facets.size() * static_cast<std::size_t>(children));
  for (const Facet& f : mesh.facets) refine_facet(mesh.dim, f, mid, named);
  const auto facet = build_facets(fine, named);

  for (const auto& [name, group] : mesh.groups) {
    if (group.kind == Group::Kind::cells) fine.groups[name] = refine_cell_group(group, mesh.dim);
    if (group.kind == Group::Kind::points) fine.groups[name] = group;
    if (group.kind != Group::Kind::facets) continue;
    Group& target = fine.groups[name];
    target.kind = Group::Kind::facets;
    target.against_another = group.against_another;
    for (const std::int32_t f : group.entities)
      for (int i = 0; i < children; ++i) target.entities.push_back(facet[f * children + i]);
    std::sort(target.entities.begin(), target.entities.end());
  }
  return fine;
}

} // namespace hvi::solver
