// See pieces.hpp.
#include "solver/mesh/pieces.hpp"

#include "solver/common/failure.hpp"
#include "solver/mesh/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace hvi::solver {
namespace {

/// What is called as a new group is.
std::string group_of_piece(const std::string& group) {
  return group == "boundary" ? "group(\"boundary\")" : group;
}

/// Adds meshes one behind the other; facets of the boundary come before those inside.
class Joint {
public:
  explicit Joint(std::span<const Mesh> meshes) {
    out_.dim = meshes.front().dim;
    out_.axisymmetric = meshes.front().axisymmetric;
    std::size_t boundary = 0;
    for (const Mesh& mesh : meshes)
      boundary += static_cast<std::size_t>(std::ranges::count_if(mesh.facets, is_outer));
    out_.facets.resize(boundary);
  }

  void add(const Mesh& mesh, const std::string& name) {
    const auto node = static_cast<std::int32_t>(out_.nodes.size());
    const auto cell = static_cast<std::int32_t>(out_.cells.size());
    check_cell_limit(static_cast<double>(out_.cells.size() + mesh.cells.size()));
    out_.pieces.push_back(cell);
    out_.nodes.insert(out_.nodes.end(), mesh.nodes.begin(), mesh.nodes.end());
    for (auto nodes : mesh.cells) {
      for (int k = 0; k <= mesh.dim; ++k) nodes[k] += node;
      out_.cells.push_back(nodes);
    }
    const auto facet_of = add_facets(mesh, node, cell);
    for (const auto& [group, entities] : mesh.groups)
      add_group(name + "." + group_of_piece(group), moved(entities, node, cell, facet_of));
    Group cells{Group::Kind::cells, std::vector<std::int32_t>(mesh.cells.size())};
    std::iota(cells.entities.begin(), cells.entities.end(), cell);
    add_group(name, std::move(cells));
    Group boundary{Group::Kind::facets, {}};
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
      if (is_outer(mesh.facets[f])) boundary.entities.push_back(facet_of[f]);
    add_group(name + ".boundary", std::move(boundary));
    out_.description += (out_.description.empty() ? "" : " + ") + mesh.description;
  }

  Mesh take() { return std::move(out_); }

private:
  static bool is_outer(const Facet& facet) { return facet.other < 0; }

  std::vector<std::int32_t> add_facets(const Mesh& mesh, std::int32_t node, std::int32_t cell) {
    std::vector<std::int32_t> number;
    for (Facet facet : mesh.facets) {
      for (int k = 0; k < mesh.dim; ++k) facet.nodes[k] += node;
      facet.cell += cell;
      if (!is_outer(facet)) {
        facet.other += cell;
        number.push_back(static_cast<std::int32_t>(out_.facets.size()));
        out_.facets.push_back(facet);
      } else {
        number.push_back(outer_);
        out_.facets[static_cast<std::size_t>(outer_++)] = facet;
      }
    }
    return number;
  }

  static Group moved(Group group, std::int32_t node, std::int32_t cell,
                     const std::vector<std::int32_t>& facet_of) {
    for (auto& e : group.entities)
      e = group.kind == Group::Kind::facets  ? facet_of[static_cast<std::size_t>(e)]
          : group.kind == Group::Kind::cells ? e + cell
                                             : e + node;
    std::ranges::sort(group.entities);
    return group;
  }

  void add_group(const std::string& name, Group group) {
    if (!out_.groups.emplace(name, std::move(group)).second)
      throw Failure(FailureKind::bad_mesh, {},
                    fmt::format("two groups of the pieces of a mesh are called `{}`", name));
  }

  Mesh out_;
  std::int32_t outer_ = 0; ///< facets of the boundary so far
};

} // namespace

Mesh side_by_side(std::span<const Mesh> meshes, std::span<const std::string> names) {
  Joint joint(meshes);
  for (std::size_t i = 0; i < meshes.size(); ++i) joint.add(meshes[i], names[i]);
  return joint.take();
}

} // namespace hvi::solver
