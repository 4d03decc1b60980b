// The text of `hvi-run mesh FILE`.
#include "solver/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace hvi::solver {
namespace {

const char* measure_name(int dim) {
  static const char* const names[] = {"points", "length", "area", "volume"};
  return names[dim];
}

std::string describe_group(const Mesh& mesh, const std::string& name, const Group& group) {
  const auto n = group.entities.size();
  std::string line = fmt::format("  {:<20} ", name);
  if (group.kind == Group::Kind::points)
    return line + fmt::format("{:>8} points{}\n", n, group.of_lines ? "  (of lines)" : "");
  const bool cells = group.kind == Group::Kind::cells;
  const int dim = cells ? mesh.dim : mesh.dim - 1;
  double measure = 0;
  std::size_t interior = 0;
  for (const std::int32_t e : group.entities) {
    measure += cells ? cell_measure(mesh, e) : facet_measure(mesh, e);
    if (!cells && mesh.facets[e].other >= 0) ++interior;
  }
  line += fmt::format("{:>8} {}", n, cells ? "cells " : "facets");
  if (dim > 0) line += fmt::format("  {} {:.6g}", measure_name(dim), measure);
  if (interior > 0) line += fmt::format("  ({} inside the body)", interior);
  return line + "\n";
}

/// Boundary facets in no group: a physical group may have been forgotten.
std::size_t unnamed_boundary(const Mesh& mesh) {
  std::set<std::int32_t> named;
  for (const auto& [name, group] : mesh.groups)
    if (group.kind == Group::Kind::facets)
      named.insert(group.entities.begin(), group.entities.end());
  std::size_t count = 0;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f)
    if (mesh.facets[f].other < 0 && !named.contains(static_cast<std::int32_t>(f))) ++count;
  return count;
}

} // namespace

std::string describe_mesh(const Mesh& mesh) {
  static const char* const cell_names[] = {"lines", "triangles", "tetrahedra"};
  const MeshQuality q = mesh_quality(mesh);
  const Box box = bounding_box(mesh);
  const auto boundary = std::count_if(mesh.facets.begin(), mesh.facets.end(),
                                      [](const Facet& f) { return f.other < 0; });
  std::string text = fmt::format("{}\n", mesh.description);
  text += fmt::format("  dimension {}, {} nodes, {} {}, {} boundary facets\n", mesh.dim,
                      mesh.nodes.size(), mesh.cells.size(), cell_names[mesh.dim - 1], boundary);
  text += "  box";
  for (int a = 0; a < mesh.dim; ++a)
    text += fmt::format("{} [{:.6g}, {:.6g}]", a ? " x" : "", box.low[a], box.high[a]);
  text += fmt::format(", {} {:.8g}, {} connected piece{}\n", measure_name(mesh.dim), q.measure,
                      q.pieces, q.pieces == 1 ? "" : "s");
  text += fmt::format("  edges {:.4g} to {:.4g}, worst aspect {:.3g} (1 is best)\n",
                      q.shortest_edge, q.longest_edge, q.worst_aspect);
  text += mesh.groups.empty() ? "no groups\n" : "groups\n";
  for (const auto& [name, group] : mesh.groups) text += describe_group(mesh, name, group);
  if (const auto rest = unnamed_boundary(mesh); rest > 0)
    text += fmt::format("  {} boundary facets are in no group\n", rest);
  return text;
}

} // namespace hvi::solver
