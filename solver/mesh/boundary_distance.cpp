// See boundary_distance.hpp.
#include "solver/mesh/boundary_distance.hpp"

#include "solver/common/triples.hpp"

#include <algorithm>
#include <limits>

namespace hvi::solver {
namespace {

Point along(const Point& a, const Point& direction, double s) {
  return {a[0] + s * direction[0], a[1] + s * direction[1], a[2] + s * direction[2]};
}

Point nearest_on_edge(const Point& p, const Point& a, const Point& b) {
  const Point edge = minus(b, a);
  const double s = dot(minus(p, a), edge) / dot(edge, edge);
  return along(a, edge, std::clamp(s, 0.0, 1.0));
}

/// The foot of the perpendicular, where it is inside; else a point of an edge.
Point nearest_on_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Point u = minus(b, a), v = minus(c, a), w = minus(p, a);
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), wu = dot(w, u), wv = dot(w, v);
  const double area = uu * vv - uv * uv; // of the parallelogram, squared
  const double s = (wu * vv - wv * uv) / area, t = (wv * uu - wu * uv) / area;
  if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) return along(along(a, u, s), v, t);
  Point best = nearest_on_edge(p, a, b);
  for (const Point& other : {nearest_on_edge(p, b, c), nearest_on_edge(p, c, a)})
    if (norm(minus(p, other)) < norm(minus(p, best))) best = other;
  return best;
}

} // namespace

NearestOnBoundary nearest_on_boundary(const Mesh& mesh, const Point& p) {
  NearestOnBoundary out{{}, std::numeric_limits<double>::infinity()};
  for (const Facet& facet : mesh.facets) {
    if (facet.other >= 0) continue;
    const auto corner = [&](int k) -> const Point& { return mesh.nodes[facet.nodes[k]]; };
    const Point at = mesh.dim == 1   ? corner(0)
                     : mesh.dim == 2 ? nearest_on_edge(p, corner(0), corner(1))
                                     : nearest_on_triangle(p, corner(0), corner(1), corner(2));
    if (const double distance = norm(minus(p, at)); distance < out.distance) out = {at, distance};
  }
  return out;
}

} // namespace hvi::solver
