// See periodic.hpp. Called where the dofs of a space are numbered.
#include "solver/fem/periodic.hpp"

#include "solver/fem/geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace hvi::solver {
namespace {

constexpr double meet_within = 1e-7; ///< of the size of the mesh
constexpr const char* help_for_meshes =
    "both sides need the same nodes and facets, moved: in gmsh `Periodic Curve {2} = {4}` or "
    "`Periodic Surface`; `adapted` meshes differ from side to side";

Box box_around(const Space& space, std::span<const std::int32_t> nodes) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Box out{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (const auto node : nodes)
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = space.nodes[static_cast<std::size_t>(node)][i];
      out.low[i] = std::min(out.low[i], x), out.high[i] = std::max(out.high[i], x);
    }
  return out;
}

double distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Nodes in the order of their places along a line that is no axis of meshes.
class AlongLine {
public:
  AlongLine(const Space& space, std::span<const std::int32_t> nodes) : space_(space) {
    for (const auto node : nodes)
      sorted_.emplace_back(along(space.nodes[static_cast<std::size_t>(node)]), node);
    std::ranges::sort(sorted_);
  }
  /// visit(node) for those within `reach` of a place.
  template <class Visit>
  void for_each_at(const Point& place, double reach, const Visit& visit) const {
    const double s = along(place);
    auto it = std::ranges::lower_bound(sorted_, std::pair(s - reach, std::int32_t{-1}));
    for (; it != sorted_.end() && it->first <= s + reach; ++it)
      if (distance(space_.nodes[static_cast<std::size_t>(it->second)], place) <= reach)
        visit(it->second);
  }

private:
  static double along(const Point& x) { return 0.5377 * x[0] + 0.6131 * x[1] + 0.5788 * x[2]; }

  const Space& space_;
  std::vector<std::pair<double, std::int32_t>> sorted_;
};

/// By node of a part, where its facets lie from it, added up: where pieces touch, several nodes of
/// a part are at one place, and this tells them apart.
std::map<std::int32_t, Point> outlooks(const Space& space, const Region& part) {
  std::map<std::int32_t, Point> out;
  for (const auto facet : part.entities) {
    const auto nodes = space.nodes_of_facet(facet);
    for (const auto node : nodes)
      for (const auto other : nodes)
        for (std::size_t i = 0; i < 3; ++i)
          out[node][i] += space.nodes[static_cast<std::size_t>(other)][i] -
                          space.nodes[static_cast<std::size_t>(node)][i];
  }
  return out;
}

/// One condition: both parts, and the node of the first one that each of the second one repeats.
class Matching {
public:
  Matching(const Space& space, const PeriodicSpec& spec, std::span<const Region> parts)
      : space_(space), spec_(spec), first_(parts[static_cast<std::size_t>(spec.first)]),
        second_(parts[static_cast<std::size_t>(spec.second)]) {
    for (const Region* region : {&first_, &second_})
      if (region->kind != Group::Kind::facets)
        refuse("periodic parts are parts of the boundary",
               "values repeat from one side of the body to another");
    match_nodes();
    match_facets();
  }
  /// From the first part to the second.
  const Point& way() const { return way_; }
  /// (second, first)
  const std::vector<std::pair<std::int32_t, std::int32_t>>& nodes() const { return nodes_; }

private:
  [[noreturn]] void refuse(const std::string& message, const char* help) const {
    throw Failure(FailureKind::bad_value, spec_.origin, message, help);
  }
  std::string at(const Point& x) const { return describe_point(x, space_.mesh->dim); }

  void match_nodes() {
    const auto first = nodes_on(space_, first_), second = nodes_on(space_, second_);
    const Box a = box_around(space_, first), b = box_around(space_, second);
    const Box all = bounding_box(*space_.mesh);
    const double reach = meet_within * distance(all.low, all.high);
    for (std::size_t i = 0; i < 3; ++i) way_[i] = b.low[i] - a.low[i];
    if (space_.mesh->axisymmetric && std::abs(way_[0]) > reach)
      throw Failure(FailureKind::bad_value, spec_.origin,
                    "periodic parts of a body of revolution lie above each other",
                    "a way along the radius changes the body");
    const Point moved{a.high[0] + way_[0], a.high[1] + way_[1], a.high[2] + way_[2]};
    if (distance(moved, b.high) > 2 * reach)
      refuse("the periodic parts differ in size: no translation takes one to the other",
             help_for_meshes);
    const AlongLine of_first(space_, first);
    const auto from_first = outlooks(space_, first_), from_second = outlooks(space_, second_);
    for (const auto node : second) {
      Point place = space_.nodes[static_cast<std::size_t>(node)];
      for (std::size_t i = 0; i < 3; ++i) place[i] -= way_[i];
      std::int32_t partner = -1;
      of_first.for_each_at(place, 2 * reach, [&](std::int32_t candidate) {
        const Point& outlook = from_second.at(node);
        if (partner < 0 ||
            distance(from_first.at(candidate), outlook) < distance(from_first.at(partner), outlook))
          partner = candidate;
      });
      if (partner < 0)
        refuse(fmt::format("the node {} of the second part has no partner: there is none of the "
                           "first one at {}",
                           at(space_.nodes[static_cast<std::size_t>(node)]), at(place)),
               help_for_meshes);
      nodes_.emplace_back(node, partner);
    }
    if (first.size() != second.size())
      refuse(fmt::format("the first part has {} nodes, the second one {}", first.size(),
                         second.size()),
             help_for_meshes);
  }

  using Corners = std::vector<std::int32_t>;
  Corners corners(std::int32_t facet) const {
    const auto nodes = space_.nodes_of_facet(facet);
    return {nodes.begin(), nodes.begin() + space_.mesh->dim};
  }
  /// In space the same nodes can be joined to other triangles.
  void match_facets() {
    std::set<Corners> of_first;
    for (const auto facet : first_.entities) {
      Corners nodes = corners(facet);
      std::ranges::sort(nodes);
      of_first.insert(std::move(nodes));
    }
    for (const auto facet : second_.entities) {
      Corners nodes = corners(facet);
      for (auto& node : nodes)
        node = std::ranges::lower_bound(nodes_, std::pair(node, std::int32_t{-1}))->second;
      std::ranges::sort(nodes);
      if (of_first.contains(nodes)) continue;
      refuse(fmt::format("the nodes of both parts meet, their facets do not: at {}",
                         at(space_.nodes[static_cast<std::size_t>(corners(facet).front())])),
             help_for_meshes);
    }
  }

  const Space& space_;
  const PeriodicSpec& spec_;
  const Region &first_, &second_;
  Point way_{};
  std::vector<std::pair<std::int32_t, std::int32_t>> nodes_;
};

/// Sets of dofs that are one, each with its smallest as its name.
class Classes {
public:
  explicit Classes(int n) : parent_(static_cast<std::size_t>(n)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  std::int32_t root(std::int32_t i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      auto& parent = parent_[static_cast<std::size_t>(i)];
      parent = parent_[static_cast<std::size_t>(parent)];
      i = parent;
    }
    return i;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = root(a), b = root(b);
    parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  std::vector<std::int32_t> take() {
    std::vector<std::int32_t> out(parent_.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = root(static_cast<std::int32_t>(i));
    return out;
  }

private:
  std::vector<std::int32_t> parent_;
};

} // namespace

std::vector<std::int32_t> periodic_dofs(const Space& space, const SpaceSpec& spec,
                                        std::span<const Region> parts) {
  if (spec.periodic.empty()) return {};
  Classes classes(space.n_dofs());
  for (const PeriodicSpec& condition : spec.periodic) {
    const SpaceBlock& block = space.blocks[static_cast<std::size_t>(condition.unknown)];
    const int first = std::max(condition.component, 0);
    const int past = condition.component < 0 ? block.components : first + 1;
    const Matching matching(space, condition, parts);
    for (const auto& [node, partner] : matching.nodes()) {
      if (has_node(space, block, node) != has_node(space, block, partner))
        throw Failure(FailureKind::bad_value, condition.origin,
                      fmt::format("`{}` lives on one of the periodic parts only", block.name),
                      "take parts of the region that its space is on");
      for (int c = first; c < past; ++c)
        classes.join(space.dof(node, block.first + c), space.dof(partner, block.first + c));
    }
  }
  return classes.take();
}

std::vector<PeriodicNote> periodic_notes(const Space& space, const Problem& problem,
                                         std::span<const Region> parts) {
  std::vector<PeriodicNote> out;
  const auto name = [&](int part) { return problem.parts[static_cast<std::size_t>(part)].name; };
  for (const PeriodicSpec& condition : problem.space.periodic) {
    const Matching matching(space, condition, parts);
    const SpaceBlock& block = space.blocks[static_cast<std::size_t>(condition.unknown)];
    const auto n = std::ranges::count_if(
        matching.nodes(), [&](const auto& pair) { return has_node(space, block, pair.first); });
    out.push_back(
        {fmt::format("periodic{} `{}` = `{}`{}",
                     condition.component < 0 ? "" : fmt::format(".{}", "xyz"[condition.component]),
                     name(condition.first), name(condition.second),
                     space.is_product() ? fmt::format(" of `{}`", block.name) : ""),
         fmt::format("moved by {}; {} nodes repeat others",
                     describe_point(matching.way(), space.mesh->dim), n),
         condition.origin});
  }
  return out;
}

} // namespace hvi::solver
