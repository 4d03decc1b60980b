// Cells that overlap; see inspect.hpp.
//
// Two convex bodies are apart if and only if their projections on one of a few axes are: the
// normals of their facets and, in 3D, the products of their edges (S. Gottschalk, M. C. Lin, D.
// Manocha, OBBTree: a hierarchical structure for rapid interference detection, 1996).
#include "solver/common/triples.hpp"
#include "solver/mesh/box_tree.hpp"
#include "solver/mesh/inspect.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

constexpr double of_edges = 1e-6, of_the_body = 1e-9;
constexpr double too_flat = 1e-9; // measure over the longest edge to the power of the dimension

/// n . x <= at for the points of a cell, n of length one.
struct Plane {
  Point normal{};
  double at = 0.0;
};

/// A cell as the half spaces of its sides.
struct Simplex {
  int dim = 0;
  std::array<Point, 4> x{};
  std::array<Plane, 4> sides{};
  double diameter = 0.0;
  bool flat = false;

  Simplex(const Mesh& mesh, std::int32_t cell) : dim(mesh.dim) {
    for (int i = 0; i <= dim; ++i) x[i] = mesh.nodes[mesh.cells[cell][i]];
    double square = 0.0;
    for (int i = 0; i <= dim; ++i)
      for (int j = 0; j < i; ++j) {
        const Point edge = minus(x[i], x[j]);
        square = std::max(square, dot(edge, edge));
      }
    diameter = std::sqrt(square);
    double whole = too_flat;
    for (int a = 0; a < dim; ++a) whole *= diameter;
    flat = !(cell_measure(mesh, cell) > whole);
    for (int i = 0; i <= dim; ++i) sides[i] = side_opposite(i);
  }

  Plane side_opposite(int corner) const {
    const int n = dim + 1;
    const Point &a = x[(corner + 1) % n], &b = x[(corner + 2) % n], &c = x[(corner + 3) % n];
    Plane out;
    if (dim == 1) out.normal = {1, 0, 0};
    if (dim == 2) out.normal = {b[1] - a[1], a[0] - b[0], 0};
    if (dim == 3) out.normal = cross(minus(b, a), minus(c, a));
    const double length =
        dot(out.normal, minus(a, x[corner])) < 0 ? -norm(out.normal) : norm(out.normal);
    for (double& v : out.normal) v /= length;
    out.at = dot(out.normal, a);
    return out;
  }
};

/// How far b reaches behind the side of another cell; negative: how far it is away from it.
double behind(const Plane& side, const Simplex& b) {
  double nearest = dot(side.normal, b.x[0]);
  for (int i = 1; i <= b.dim; ++i) nearest = std::min(nearest, dot(side.normal, b.x[i]));
  return side.at - nearest;
}

/// How far the projections on an axis overlap.
double overlap_along(const Point& axis, const Simplex& a, const Simplex& b) {
  const auto range = [&](const Simplex& s) {
    std::pair<double, double> out{std::numeric_limits<double>::infinity(),
                                  -std::numeric_limits<double>::infinity()};
    for (const Point& x : s.x) {
      const double at = dot(axis, minus(x, a.x[0]));
      out = {std::min(out.first, at), std::max(out.second, at)};
    }
    return out;
  };
  const auto [low_a, high_a] = range(a);
  const auto [low_b, high_b] = range(b);
  return std::min(high_a - low_b, high_b - low_a) / norm(axis);
}

/// By how little one of the two has to be moved to come free of the other, or something no more
/// than `least`.
double depth(const Simplex& a, const Simplex& b, double least) {
  double out = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= a.dim; ++i)
    if ((out = std::min(out, behind(a.sides[i], b))) <= least) return out;
  for (int i = 0; i <= b.dim; ++i)
    if ((out = std::min(out, behind(b.sides[i], a))) <= least) return out;
  if (a.dim < 3) return out;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      static constexpr int ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
      const Point u = minus(a.x[ends[i][1]], a.x[ends[i][0]]),
                  v = minus(b.x[ends[j][1]], b.x[ends[j][0]]), axis = cross(u, v);
      // Edges that are all but parallel: the product is rounding, and the sides do.
      if (!(norm(axis) > 1e-8 * norm(u) * norm(v))) continue;
      if ((out = std::min(out, overlap_along(axis, a, b))) <= least) return out;
    }
  return out;
}

/// Cells with a common facet lie on its two sides: build_facets has seen to that.
bool share_a_facet(const Mesh& mesh, std::int32_t a, std::int32_t b) {
  const auto &p = mesh.cells[a], &q = mesh.cells[b];
  int common = 0;
  for (int i = 0; i <= mesh.dim; ++i)
    for (int j = 0; j <= mesh.dim; ++j) common += p[i] == q[j] ? 1 : 0;
  return common == mesh.dim;
}

Point centre(const Mesh& mesh, std::int32_t cell) {
  Point out{};
  for (int i = 0; i <= mesh.dim; ++i)
    for (int a = 0; a < 3; ++a) out[a] += mesh.nodes[mesh.cells[cell][i]][a] / (mesh.dim + 1);
  return out;
}

} // namespace

std::optional<Overlap> find_overlap(const Mesh& mesh) {
  std::vector<std::int32_t> number(mesh.cells.size(), -1), outer;
  std::vector<Box> boxes;
  std::vector<Simplex> simplices;
  for (const Facet& f : mesh.facets) {
    if (f.other >= 0 || number[f.cell] >= 0) continue;
    number[f.cell] = static_cast<std::int32_t>(outer.size());
    outer.push_back(f.cell);
    boxes.push_back(box_of(mesh, f.cell));
    simplices.emplace_back(mesh, f.cell);
  }
  const BoxTree tree(std::move(boxes));
  const double least_of_body = of_the_body * bounding_box(mesh).diagonal();
  std::vector<bool> counted(outer.size(), false);
  Overlap out;
  for (std::int32_t c = 0; c < static_cast<std::int32_t>(mesh.cells.size()); ++c) {
    std::optional<Simplex> mine;
    tree.for_each_meeting(box_of(mesh, c), [&](std::int32_t i) {
      const std::int32_t other = outer[i];
      if (other == c || (number[c] >= 0 && other < c) || share_a_facet(mesh, c, other)) return;
      if (!mine) mine.emplace(mesh, c);
      const Simplex& its = simplices[i];
      const double least =
          std::max(of_edges * std::min(mine->diameter, its.diameter), least_of_body);
      const double found = depth(*mine, its, least);
      if (!(found > least) || mine->flat || its.flat) return;
      for (const auto at : {number[c], i}) {
        if (at < 0 || counted[at]) continue;
        counted[at] = true;
        ++out.cells;
      }
      if (found <= out.depth) return;
      out.depth = found;
      out.at = centre(mesh, other);
      out.cell = other;
      out.other = c;
    });
  }
  if (out.cells == 0) return std::nullopt;
  return out;
}

} // namespace hvi::solver
