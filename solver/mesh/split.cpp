// See split.hpp.
#include "solver/mesh/split.hpp"

#include "solver/common/failure.hpp"
#include "solver/mesh/facet_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace hvi::solver {
namespace {

using Side = std::array<std::int32_t, 3>; ///< nodes of a facet, sorted

Side side_of(const Mesh& mesh, const std::array<std::int32_t, 4>& cell, int left_out) {
  Side out{-1, -1, -1};
  for (int k = 0, n = 0; k <= mesh.dim; ++k)
    if (k != left_out) out[static_cast<std::size_t>(n++)] = cell[static_cast<std::size_t>(k)];
  std::ranges::sort(out);
  return out;
}

class Cut {
public:
  Cut(Mesh& mesh, const std::string& name, const std::vector<std::int32_t>& facets)
      : mesh_(mesh), name_(name), facets_(facets) {}

  void run() {
    for (const auto f : facets_) {
      const Facet& facet = mesh_.facets[static_cast<std::size_t>(f)];
      if (facet.other < 0) throw on_boundary();
      Side side = facet.nodes;
      std::ranges::sort(side);
      cut_.insert(side);
      for (int k = 0; k < mesh_.dim; ++k) nodes_.insert(facet.nodes[static_cast<std::size_t>(k)]);
    }
    collect_cells();
    for (const auto& [node, cells] : cells_) divide(node, cells);
    add_facets();
    rename();
  }

private:
  Failure on_boundary() const {
    return Failure(FailureKind::bad_mesh, {},
                   fmt::format("the group `{}` has facets of the boundary, or of a cut", name_),
                   "a mesh is cut along facets inside it, each of them once");
  }

  void collect_cells() {
    for (std::size_t c = 0; c < mesh_.cells.size(); ++c)
      for (int k = 0; k <= mesh_.dim; ++k) {
        const auto node = mesh_.cells[c][static_cast<std::size_t>(k)];
        if (nodes_.contains(node)) cells_[node].push_back(static_cast<std::int32_t>(c));
      }
  }

  /// The cells around a node come apart where no way through uncut sides leads from one to the
  /// other; all but the first part get a node of their own.
  void divide(std::int32_t node, const std::vector<std::int32_t>& cells) {
    std::vector<std::size_t> part(cells.size());
    std::iota(part.begin(), part.end(), std::size_t{0});
    std::map<Side, std::size_t> seen;
    for (std::size_t i = 0; i < cells.size(); ++i)
      for (int k = 0; k <= mesh_.dim; ++k) {
        const auto& cell = mesh_.cells[static_cast<std::size_t>(cells[i])];
        if (cell[static_cast<std::size_t>(k)] == node) continue; // that side is opposite to it
        const Side side = side_of(mesh_, cell, k);
        if (cut_.contains(side)) continue;
        const auto [other, fresh] = seen.try_emplace(side, i);
        if (!fresh) unite(part, other->second, i);
      }
    std::map<std::size_t, std::int32_t> node_of{{part.front(), node}};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto [own, fresh] =
          node_of.try_emplace(part[i], static_cast<std::int32_t>(mesh_.nodes.size()));
      if (fresh) mesh_.nodes.push_back(Point(mesh_.nodes[static_cast<std::size_t>(node)]));
      if (own->second != node) moved_[{cells[i], node}] = own->second;
    }
  }

  static void unite(std::vector<std::size_t>& part, std::size_t a, std::size_t b) {
    const auto from = part[b], to = part[a];
    std::ranges::replace(part, from, to);
  }

  std::int32_t at(std::int32_t cell, std::int32_t node) const {
    const auto found = moved_.find({cell, node});
    return found == moved_.end() ? node : found->second;
  }

  /// Between cells that keep all its nodes in common: nothing opens there.
  bool stays(const Facet& facet) const {
    for (int k = 0; k < mesh_.dim; ++k) {
      const auto node = facet.nodes[static_cast<std::size_t>(k)];
      if (at(facet.cell, node) != at(facet.other, node)) return false;
    }
    return true;
  }

  void add_facets() {
    Group first{Group::Kind::facets, {}}, second{Group::Kind::facets, {}};
    for (const auto f : facets_) {
      Facet& facet = mesh_.facets[static_cast<std::size_t>(f)];
      if (stays(facet)) continue;
      Facet other = facet;
      turn(mesh_.dim, other.nodes);
      other.cell = std::exchange(facet.other, -1);
      other.other = -1;
      first.entities.push_back(f);
      second.entities.push_back(static_cast<std::int32_t>(mesh_.facets.size()));
      mesh_.facets.push_back(other);
    }
    mesh_.groups.erase(name_);
    mesh_.groups[name_ + ".first"] = std::move(first);
    mesh_.groups[name_ + ".second"] = std::move(second);
  }

  void rename() {
    for (Facet& facet : mesh_.facets)
      for (int k = 0; k < mesh_.dim; ++k) {
        auto& node = facet.nodes[static_cast<std::size_t>(k)];
        node = at(facet.cell, node);
      }
    for (const auto& [place, node] : moved_)
      for (auto& corner : mesh_.cells[static_cast<std::size_t>(place.first)])
        if (corner == place.second) corner = node;
  }

  Mesh& mesh_;
  std::string name_;
  std::vector<std::int32_t> facets_; ///< a copy: the group goes
  std::set<Side> cut_;
  std::set<std::int32_t> nodes_;
  std::map<std::int32_t, std::vector<std::int32_t>> cells_; ///< around the nodes of the cut
  /// By cell and node: the node in place of it.
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> moved_;
};

} // namespace

void split(Mesh& mesh, std::span<const std::string> groups) {
  for (const std::string& name : groups) {
    const auto found = mesh.groups.find(name);
    if (found == mesh.groups.end())
      throw Failure(FailureKind::unknown_group, {},
                    fmt::format("the mesh {} has no group `{}` to be cut", mesh.description, name));
    if (found->second.kind != Group::Kind::facets)
      throw Failure(
          FailureKind::bad_mesh, {},
          fmt::format("the group `{}`, along which the mesh is cut, has no facets", name));
    Cut(mesh, name, found->second.entities).run();
  }
}

} // namespace hvi::solver
