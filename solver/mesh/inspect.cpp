// Seams and pieces of a mesh; see inspect.hpp.
#include "solver/mesh/inspect.hpp"

#include "solver/common/triples.hpp"
#include "solver/mesh/box_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_map>

namespace hvi::solver {
namespace {

constexpr double same_place = 1e-8; // of the body
constexpr double of_an_edge = 1e-3; // there, or of a cell's height: bodies may be thin
constexpr double slack = 1e-9;      // of barycentric coordinates: edges belong to their sides

double distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

std::vector<std::int32_t> boundary_nodes(const Mesh& mesh) {
  std::vector<bool> on(mesh.nodes.size(), false);
  std::vector<std::int32_t> out;
  for (const Facet& f : mesh.facets) {
    for (int k = 0; k < mesh.dim && f.other < 0; ++k) {
      if (!on[f.nodes[k]]) out.push_back(f.nodes[k]);
      on[f.nodes[k]] = true;
    }
  }
  return out;
}

/// The shortest edge at each of these nodes.
std::unordered_map<std::int32_t, double>
shortest_edges(const Mesh& mesh, const std::vector<std::pair<std::int32_t, std::int32_t>>& pairs) {
  std::unordered_map<std::int32_t, double> out;
  std::vector<bool> asked(mesh.nodes.size(), false);
  for (const auto& [a, b] : pairs) {
    out[a] = out[b] = std::numeric_limits<double>::infinity();
    asked[a] = asked[b] = true;
  }
  for (const auto& c : mesh.cells)
    for (int i = 0; i <= mesh.dim; ++i)
      for (int j = 0; j <= mesh.dim && asked[c[i]]; ++j)
        if (i != j) out[c[i]] = std::min(out[c[i]], distance(mesh.nodes[c[i]], mesh.nodes[c[j]]));
  return out;
}

/// Pairs of nodes no farther apart than `reach`: sorted along a direction that no mesh is aligned
/// with, so that few nodes are neighbours in that order.
template <class Visit>
void for_close_pairs(const Mesh& mesh, const std::vector<std::int32_t>& nodes, double reach,
                     const Visit& visit) {
  std::vector<std::pair<double, std::int32_t>> along;
  along.reserve(nodes.size());
  for (const auto n : nodes) {
    const Point& p = mesh.nodes[n];
    along.emplace_back(0.5403023058681398 * p[0] + 0.6870265319 * p[1] + 0.4859165 * p[2], n);
  }
  std::sort(along.begin(), along.end());
  for (std::size_t i = 0; i < along.size(); ++i) {
    for (std::size_t j = i + 1; j < along.size(); ++j) {
      if (along[j].first - along[i].first > reach) break;
      if (distance(mesh.nodes[along[i].second], mesh.nodes[along[j].second]) <= reach)
        visit(along[i].second, along[j].second);
    }
  }
}

Box box_of(const Mesh& mesh, const Facet& f, double margin) {
  Box box{mesh.nodes[f.nodes[0]], mesh.nodes[f.nodes[0]]};
  for (int k = 1; k < mesh.dim; ++k) include(box, {mesh.nodes[f.nodes[k]], mesh.nodes[f.nodes[k]]});
  for (int a = 0; a < 3; ++a) box.low[a] -= margin, box.high[a] += margin;
  return box;
}

/// Does p lie in an edge (2D) or a triangle (3D), no farther from it than `reach`, and farther from
/// its corners?
bool lies_inside(const Mesh& mesh, const Facet& f, const Point& p, double reach) {
  const Point& a = mesh.nodes[f.nodes[0]];
  std::array<Point, 2> side{};
  Point to{};
  for (int i = 0; i < 3; ++i) {
    to[i] = p[i] - a[i];
    for (int k = 0; k + 1 < mesh.dim; ++k) side[k][i] = mesh.nodes[f.nodes[k + 1]][i] - a[i];
  }
  double x = dot(side[0], to), y = 0.0;
  if (mesh.dim == 2) {
    x /= dot(side[0], side[0]);
  } else { // least squares: [uu uv; uv vv] (x, y) = (u.to, v.to)
    const double uu = dot(side[0], side[0]), uv = dot(side[0], side[1]), vv = dot(side[1], side[1]),
                 u = x, v = dot(side[1], to);
    const double whole = uu * vv - uv * uv;
    x = (vv * u - uv * v) / whole;
    y = (uu * v - uv * u) / whole;
  }
  const double least = mesh.dim == 2 ? std::min(x, 1 - x) : std::min({x, y, 1 - x - y});
  if (!(least > -slack)) return false;
  for (int k = 0; k < mesh.dim; ++k)
    if (distance(mesh.nodes[f.nodes[k]], p) <= reach) return false;
  Point foot = a;
  for (int i = 0; i < 3; ++i) foot[i] += x * side[0][i] + y * side[1][i];
  return distance(foot, p) <= reach;
}

/// Nodes that lie in a side of the boundary without being a corner of it.
std::set<std::int32_t> hanging_nodes(const Mesh& mesh, const std::vector<std::int32_t>& nodes,
                                     double reach) {
  std::set<std::int32_t> out;
  if (mesh.dim == 1) return out;
  std::vector<Box> boxes;
  std::vector<std::size_t> facets;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    if (mesh.facets[f].other >= 0) continue;
    boxes.push_back(box_of(mesh, mesh.facets[f], reach));
    facets.push_back(f);
  }
  const BoxTree tree(std::move(boxes));
  for (const auto n : nodes) {
    const Point& p = mesh.nodes[n];
    tree.for_each_meeting({p, p}, [&](std::int32_t i) {
      const Facet& f = mesh.facets[facets[i]];
      if (std::find(f.nodes.begin(), f.nodes.end(), n) != f.nodes.end()) return;
      const double height =
          mesh.dim * cell_measure(mesh, f.cell) / facet_measure(mesh, static_cast<int>(facets[i]));
      if (lies_inside(mesh, f, p, std::min(reach, of_an_edge * height))) out.insert(n);
    });
  }
  return out;
}

bool has_any(const Mesh& mesh, const Group& group, std::int32_t entity,
             const std::set<std::int32_t>& nodes) {
  if (group.kind == Group::Kind::points) return nodes.contains(entity);
  const bool cells = group.kind == Group::Kind::cells;
  for (int k = 0; k < mesh.dim + (cells ? 1 : 0); ++k)
    if (nodes.contains(cells ? mesh.cells[entity][k] : mesh.facets[entity].nodes[k])) return true;
  return false;
}

std::vector<std::string> groups_with(const Mesh& mesh, const std::set<std::int32_t>& nodes) {
  std::vector<std::string> out;
  for (const auto& [name, group] : mesh.groups)
    if (std::any_of(group.entities.begin(), group.entities.end(),
                    [&, &one = group](std::int32_t e) { return has_any(mesh, one, e, nodes); }))
      out.push_back(name);
  return out;
}

} // namespace

std::optional<Seam> find_seam(const Mesh& mesh) {
  const auto nodes = boundary_nodes(mesh);
  const double reach = same_place * bounding_box(mesh).diagonal();
  std::vector<std::pair<std::int32_t, std::int32_t>> close;
  for_close_pairs(mesh, nodes, reach,
                  [&](std::int32_t a, std::int32_t b) { close.emplace_back(std::minmax(a, b)); });
  std::set<std::int32_t> removed, marked;
  if (!close.empty()) {
    const auto shortest = shortest_edges(mesh, close);
    for (const auto& [a, b] : close) {
      const double edge = std::min(shortest.at(a), shortest.at(b));
      if (distance(mesh.nodes[a], mesh.nodes[b]) > of_an_edge * edge) continue;
      removed.insert(b);
      marked.insert({a, b});
    }
  }
  const auto hanging = hanging_nodes(mesh, nodes, reach);
  marked.insert(hanging.begin(), hanging.end());
  if (marked.empty()) return std::nullopt;
  Seam out;
  out.doubled = removed.size();
  out.hanging = hanging.size();
  out.at = mesh.nodes[removed.empty() ? *hanging.begin() : *removed.begin()];
  out.groups = groups_with(mesh, marked);
  return out;
}

std::vector<Piece> measure_pieces(const Mesh& mesh, const std::vector<std::int32_t>& piece_of) {
  std::vector<Piece> out;
  for (std::size_t c = 0; c < piece_of.size(); ++c) {
    const auto p = static_cast<std::size_t>(piece_of[c]);
    if (p == out.size()) {
      out.emplace_back();
      for (int k = 0; k <= mesh.dim; ++k)
        for (int a = 0; a < mesh.dim; ++a)
          out[p].at[a] += mesh.nodes[mesh.cells[c][k]][a] / (mesh.dim + 1);
    }
    ++out[p].cells;
    out[p].measure += cell_measure(mesh, static_cast<int>(c));
  }
  return out;
}

} // namespace hvi::solver
