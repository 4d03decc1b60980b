// Nodes and connectivity of P1 and P2 spaces.
#include "solver/fem/space.hpp"

#include "solver/common/joined.hpp"
#include "solver/fem/element.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace hvi::solver {
namespace {

/// Numbers the edges of a mesh: for each vertex the edges to higher vertices, sorted.
class EdgeNumbers {
public:
  explicit EdgeNumbers(const Mesh& mesh) : offsets_(mesh.nodes.size() + 1, 0) {
    const auto& edges = simplex_edges(mesh.dim);
    for_each_edge(mesh, edges, [&](int low, int) { ++offsets_[low + 1]; });
    for (std::size_t i = 1; i < offsets_.size(); ++i) {
      offsets_[i] += offsets_[i - 1];
    }
    ends_.resize(offsets_.back());
    std::vector<std::int32_t> next(offsets_.begin(), offsets_.end() - 1);
    for_each_edge(mesh, edges, [&](int low, int high) { ends_[next[low]++] = high; });
    remove_repeats();
  }
  int count() const { return static_cast<int>(ends_.size()); }
  int find(int a, int b) const {
    const auto [low, high] = std::minmax(a, b);
    const auto first = ends_.begin() + offsets_[low], last = ends_.begin() + offsets_[low + 1];
    return static_cast<int>(std::lower_bound(first, last, high) - ends_.begin());
  }
  /// f(edge, low vertex, high vertex)
  template <class F>
  void for_all(F&& f) const {
    for (int low = 0; low + 1 < static_cast<int>(offsets_.size()); ++low) {
      for (int e = offsets_[low]; e < offsets_[low + 1]; ++e) {
        f(e, low, ends_[e]);
      }
    }
  }

private:
  template <class F>
  static void for_each_edge(const Mesh& mesh, const std::vector<std::array<int, 2>>& edges, F&& f) {
    for (const auto& cell : mesh.cells) {
      for (const auto& [a, b] : edges) {
        f(std::min(cell[a], cell[b]), std::max(cell[a], cell[b]));
      }
    }
  }
  void remove_repeats() {
    std::int32_t kept = 0, begin = 0;
    for (std::size_t i = 0; i + 1 < offsets_.size(); ++i) {
      const std::int32_t end = offsets_[i + 1];
      std::sort(ends_.begin() + begin, ends_.begin() + end);
      const auto last = std::unique(ends_.begin() + begin, ends_.begin() + end);
      const auto unique_end = static_cast<std::int32_t>(last - ends_.begin());
      for (std::int32_t e = begin; e < unique_end; ++e) {
        ends_[kept++] = ends_[e];
      }
      begin = end;
      offsets_[i + 1] = kept;
    }
    ends_.resize(kept);
  }
  std::vector<std::int32_t> offsets_, ends_;
};

/// Appends the vertices of one cell or facet, and for P2 its edge nodes.
void append_nodes(const Space& space, const EdgeNumbers* edges, int dim,
                  const std::int32_t* corners, std::vector<std::int32_t>& out) {
  out.insert(out.end(), corners, corners + dim + 1);
  if (!edges) {
    return;
  }
  const auto first = static_cast<std::int32_t>(space.mesh->nodes.size());
  for (const auto& [a, b] : simplex_edges(dim)) {
    out.push_back(first + edges->find(corners[a], corners[b]));
  }
}

void append_connectivity(Space& space, const EdgeNumbers* edges) {
  const Mesh& mesh = *space.mesh;
  space.cell_nodes.reserve(mesh.cells.size() * space.nodes_per_cell);
  for (const auto& cell : mesh.cells) {
    append_nodes(space, edges, mesh.dim, cell.data(), space.cell_nodes);
  }
  for (const auto& facet : mesh.facets) {
    append_nodes(space, edges, mesh.dim - 1, facet.nodes.data(), space.facet_nodes);
  }
}

} // namespace

NodeGraph make_node_graph(std::size_t n_nodes, std::span<const std::int32_t> element_nodes,
                          int nodes_per_element) {
  // Two passes: the elements of each node by counting, then for each node the distinct nodes of its
  // elements (a mark per node instead of sorting pairs).
  std::vector<std::int32_t> first(n_nodes + 1, 0), elements(element_nodes.size());
  for (const auto node : element_nodes) {
    ++first[node + 1];
  }
  for (std::size_t i = 0; i < n_nodes; ++i) {
    first[i + 1] += first[i];
  }
  std::vector<std::int32_t> next(first.begin(), first.end() - 1);
  for (std::size_t k = 0; k < element_nodes.size(); ++k) {
    elements[next[element_nodes[k]]++] = static_cast<std::int32_t>(k / nodes_per_element);
  }
  NodeGraph graph;
  graph.offsets.reserve(n_nodes + 1);
  graph.offsets.push_back(0);
  graph.neighbours.reserve(n_nodes * nodes_per_element * 3);
  std::vector<std::int32_t> mark(n_nodes, -1);
  for (std::size_t i = 0; i < n_nodes; ++i) {
    const auto begin = graph.neighbours.size();
    for (auto e = first[i]; e < first[i + 1]; ++e) {
      const auto* nodes = element_nodes.data() + std::size_t(elements[e]) * nodes_per_element;
      for (int k = 0; k < nodes_per_element; ++k) {
        if (mark[nodes[k]] == static_cast<std::int32_t>(i)) {
          continue;
        }
        mark[nodes[k]] = static_cast<std::int32_t>(i);
        graph.neighbours.push_back(nodes[k]);
      }
    }
    std::sort(graph.neighbours.begin() + static_cast<std::ptrdiff_t>(begin),
              graph.neighbours.end());
    graph.offsets.push_back(static_cast<std::int32_t>(graph.neighbours.size()));
  }
  return graph;
}

double PartIndicators::value(int part, Group::Kind kind, int entity, int cell) const {
  const Part& p = parts[static_cast<std::size_t>(part)];
  if (p.kind == kind) {
    return p.inside[entity];
  }
  return p.kind == Group::Kind::cells ? p.inside[cell] : 0.0;
}

std::shared_ptr<const PartIndicators> make_indicators(const Mesh& mesh,
                                                      std::span<const Region> parts) {
  auto indicators = std::make_shared<PartIndicators>();
  for (const Region& region : parts) {
    const std::size_t size = region.kind == Group::Kind::cells    ? mesh.cells.size()
                             : region.kind == Group::Kind::facets ? mesh.facets.size()
                                                                  : mesh.nodes.size();
    std::vector<std::uint8_t> inside(size, 0);
    for (const auto entity : region.entities) {
      inside[entity] = 1;
    }
    indicators->parts.push_back({region.kind, std::move(inside)});
  }
  return indicators;
}

namespace {

/// A space of this order without unknowns.
Space nodes_of_order(const Mesh& mesh, int order) {
  if (order < 1 || order > 2) throw std::invalid_argument("a space is P1 or P2");
  Space space;
  space.mesh = &mesh;
  space.order = order;
  space.nodes = mesh.nodes;
  space.nodes_per_cell = lagrange_size(mesh.dim, order);
  space.nodes_per_facet = lagrange_size(mesh.dim - 1, order);
  if (order == 1) {
    append_connectivity(space, nullptr);
  } else {
    const EdgeNumbers edges(mesh);
    space.nodes.resize(mesh.nodes.size() + edges.count());
    edges.for_all([&](int edge, int a, int b) {
      Point& middle = space.nodes[mesh.nodes.size() + edge];
      for (int j = 0; j < 3; ++j) {
        middle[j] = 0.5 * (mesh.nodes[a][j] + mesh.nodes[b][j]);
      }
    });
    append_connectivity(space, &edges);
  }
  space.graph = std::make_shared<const NodeGraph>(
      make_node_graph(space.nodes.size(), space.cell_nodes, space.nodes_per_cell));
  return space;
}

} // namespace

Space make_space(const Mesh& mesh, int order, int components, std::span<const Region> parts) {
  if (components < 1 || components > 3) {
    throw std::invalid_argument("a function has one to three components");
  }
  Space space = nodes_of_order(mesh, order);
  space.components = components;
  space.blocks.front() = {"u", 0, components, order};
  space.indicators = make_indicators(mesh, parts);
  return space;
}

std::shared_ptr<const SpaceDomain> domain_of_cells(const Space& space, Region cells, int part) {
  auto out = std::make_shared<SpaceDomain>();
  out->part = part;
  out->cells = std::move(cells);
  out->has_cell.assign(space.mesh->cells.size(), 0);
  out->has_node.assign(space.nodes.size(), 0);
  for (const auto cell : out->cells.entities) {
    out->has_cell[static_cast<std::size_t>(cell)] = 1;
    for (const auto node : space.nodes_of_cell(cell))
      out->has_node[static_cast<std::size_t>(node)] = 1;
  }
  return out;
}

namespace {

std::shared_ptr<const SpaceDomain> make_domain(const Space& space, int part, const Region& cells,
                                               Origin origin) {
  if (cells.kind != Group::Kind::cells)
    throw Failure(FailureKind::bad_value, origin, "a space lives on cells of the mesh",
                  "take a mesh, a piece of it, or a part of its cells");
  return domain_of_cells(space, cells, part);
}

} // namespace

Region cells_of(const Space& space, const SpaceBlock& block) {
  if (block.domain) return block.domain->cells;
  Region out;
  out.kind = Group::Kind::cells;
  out.entities.resize(space.mesh->cells.size());
  std::iota(out.entities.begin(), out.entities.end(), 0);
  return out;
}

Space make_space(const Mesh& mesh, const SpaceSpec& spec, std::span<const Region> parts) {
  const auto unknowns = unknowns_of(spec);
  const auto highest = std::ranges::max_element(unknowns, {}, &UnknownSpec::order);
  Space space = nodes_of_order(mesh, highest->order);
  space.blocks.clear();
  space.components = 0;
  for (const UnknownSpec& unknown : unknowns) {
    const int components = components_of(unknown, mesh.dim);
    space.blocks.push_back({unknown.name, space.components, components, unknown.order});
    if (unknown.domain >= 0)
      space.blocks.back().domain = make_domain(
          space, unknown.domain, parts[static_cast<std::size_t>(unknown.domain)], unknown.origin);
    space.components += components;
  }
  space.indicators = make_indicators(mesh, parts);
  return space;
}

bool Space::is_mixed() const {
  return std::ranges::any_of(blocks, [&](const SpaceBlock& b) { return b.order < order; });
}

int Space::block_of(int component) const {
  int b = 0;
  while (component >=
         blocks[static_cast<std::size_t>(b)].first + blocks[static_cast<std::size_t>(b)].components)
    ++b;
  return b;
}

std::vector<std::int32_t> nodes_on(const Space& space, const Region& region) {
  if (region.kind == Group::Kind::points) {
    return region.entities;
  }
  std::vector<std::int32_t> nodes;
  for (const auto entity : region.entities) {
    const auto of_entity = region.kind == Group::Kind::cells ? space.nodes_of_cell(entity)
                                                             : space.nodes_of_facet(entity);
    nodes.insert(nodes.end(), of_entity.begin(), of_entity.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::string describe_point(const Point& point, int dim) {
  return fmt::format("({})", joined(point, dim, 6));
}

std::string describe_dof(const Space& space, int dof) {
  const auto& node = space.nodes[static_cast<std::size_t>(dof / space.components)];
  const int component = dof % space.components;
  const SpaceBlock& block = space.blocks[static_cast<std::size_t>(space.block_of(component))];
  const std::string name = block.components == 1
                               ? block.name
                               : fmt::format("{}_{}", block.name, "xyz"[component - block.first]);
  return name + " at node " + describe_point(node, space.mesh->dim);
}

} // namespace hvi::solver
