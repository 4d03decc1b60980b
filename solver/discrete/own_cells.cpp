// See own_cells.hpp.
#include "solver/discrete/own_cells.hpp"

#include "solver/common/metis_turn.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <new>
#include <numeric>
#include <utility>

namespace hvi::solver {
namespace {

using Indices = std::vector<std::int32_t>;

/// Fewer nodes than this for each process are not worth a search.
constexpr int few_nodes = 8;

/// Some entities of the whole, in their order, and back; -1: not among them.
struct Chosen {
  Indices whole, here;
  explicit Chosen(const std::vector<char>& in) : here(in.size(), -1) {
    for (std::size_t i = 0; i < in.size(); ++i)
      if (in[i] != 0) {
        here[i] = static_cast<std::int32_t>(whole.size());
        whole.push_back(static_cast<std::int32_t>(i));
      }
  }
  std::int32_t operator[](std::int32_t i) const {
    return i < 0 ? -1 : here[static_cast<std::size_t>(i)];
  }
};

class Cut {
public:
  Cut(const Discretisation& d, const StateLayout& layout, std::span<const std::int32_t> of_node,
      int p, std::span<const int> parts, std::span<const std::int32_t> also)
      : d_(d), layout_(layout), of_node_(of_node), p_(p), parts_(parts), cells_(own_cells()),
        nodes_(their_nodes(also)), facets_(needed_facets()) {}

  void put_mesh(StateWriter& w) const;
  void put_space(StateWriter& w) const;
  void put_regions(StateWriter& w) const;
  OwnEntries put_layout(StateWriter& w) const;
  Indices cells() const { return cells_.whole; }

private:
  /// Has this process the row of a state's entry?
  bool is_own(std::int32_t entry) const {
    return entry >= 0 && entry < layout_.n_unknowns &&
           of_node_[layout_.dof_of[entry] / d_.space.components] == p_;
  }
  std::vector<char> own_cells() const;
  std::vector<char> their_nodes(std::span<const std::int32_t> also) const;
  std::vector<char> needed_facets() const;
  void put_block(StateWriter& w, const SpaceBlock& block) const;
  const Chosen& of_kind(Group::Kind kind) const {
    return kind == Group::Kind::cells ? cells_ : kind == Group::Kind::facets ? facets_ : nodes_;
  }

  const Discretisation& d_;
  const StateLayout& layout_;
  std::span<const std::int32_t> of_node_;
  int p_;
  std::span<const int> parts_;
  Chosen cells_, nodes_, facets_;
};

/// A node of a periodic part has the rows of the one that it repeats.
std::vector<char> Cut::own_cells() const {
  std::vector<char> own(d_.space.nodes.size(), 0);
  for (int dof = 0; dof < layout_.n_dofs; ++dof)
    if (is_own(layout_.entry_of[dof])) own[dof / d_.space.components] = 1;
  std::vector<char> out(d_.mesh.cells.size(), 0);
  for (std::size_t c = 0; c < out.size(); ++c)
    out[c] = std::ranges::any_of(d_.space.nodes_of_cell(static_cast<int>(c)),
                                 [&](auto node) { return own[node] != 0; });
  return out;
}

std::vector<char> Cut::their_nodes(std::span<const std::int32_t> also) const {
  std::vector<char> out(d_.space.nodes.size(), 0);
  for (const auto cell : cells_.whole)
    for (const auto node : d_.space.nodes_of_cell(cell)) out[node] = 1;
  for (const auto entry : also) out[layout_.dof_of[entry] / d_.space.components] = 1;
  return out;
}

/// Those of the parts whose cell is here.
std::vector<char> Cut::needed_facets() const {
  std::vector<char> out(d_.mesh.facets.size(), 0);
  for (const int part : parts_) {
    const Region& region = d_.parts[static_cast<std::size_t>(part)];
    if (region.kind != Group::Kind::facets) continue;
    for (const auto facet : region.entities)
      out[facet] = cells_[d_.mesh.facets[static_cast<std::size_t>(facet)].cell] >= 0;
  }
  return out;
}

void Cut::put_mesh(StateWriter& w) const {
  const Mesh& mesh = d_.mesh;
  w.put(mesh.dim);
  w.put(mesh.axisymmetric);
  std::vector<Point> corners; // the mesh's nodes come first among those of the space
  for (const auto node : nodes_.whole)
    if (static_cast<std::size_t>(node) < mesh.nodes.size())
      corners.push_back(mesh.nodes[static_cast<std::size_t>(node)]);
  w.put(corners);
  std::vector<std::array<std::int32_t, 4>> cells;
  for (const auto cell : cells_.whole) {
    auto of = mesh.cells[static_cast<std::size_t>(cell)];
    for (int k = 0; k < mesh.nodes_per_cell(); ++k) of[k] = nodes_[of[k]];
    cells.push_back(of);
  }
  w.put(cells);
  std::vector<Facet> facets;
  for (const auto facet : facets_.whole) {
    Facet of = mesh.facets[static_cast<std::size_t>(facet)];
    for (int k = 0; k < mesh.nodes_per_facet(); ++k) of.nodes[k] = nodes_[of.nodes[k]];
    of.cell = cells_[of.cell], of.other = cells_[of.other];
    facets.push_back(of);
  }
  w.put(facets);
}

void Cut::put_block(StateWriter& w, const SpaceBlock& block) const {
  put_text(w, block.name);
  w.put(block.first);
  w.put(block.components);
  w.put(block.order);
  Indices cells; // of its domain
  if (block.domain)
    for (const auto cell : block.domain->cells.entities)
      if (const auto here = cells_[cell]; here >= 0) cells.push_back(here);
  w.put(block.domain != nullptr ? block.domain->part : -1);
  w.put(cells);
}

void Cut::put_space(StateWriter& w) const {
  const Space& space = d_.space;
  w.put(space.order);
  w.put(space.components);
  w.put(static_cast<int>(space.blocks.size()));
  for (const SpaceBlock& block : space.blocks) put_block(w, block);
  std::vector<Point> nodes;
  for (const auto node : nodes_.whole) nodes.push_back(space.nodes[static_cast<std::size_t>(node)]);
  w.put(nodes);
  Indices of_cells, of_facets;
  for (const auto cell : cells_.whole)
    for (const auto node : space.nodes_of_cell(cell)) of_cells.push_back(nodes_[node]);
  for (const auto facet : facets_.whole)
    for (const auto node : space.nodes_of_facet(facet)) of_facets.push_back(nodes_[node]);
  w.put(of_cells);
  w.put(of_facets);
}

/// The parts, and which entities are in them (slot::inside).
void Cut::put_regions(StateWriter& w) const {
  w.put(static_cast<int>(d_.parts.size()));
  for (std::size_t part = 0; part < d_.parts.size(); ++part) {
    const Region& region = d_.parts[part];
    Indices entities;
    if (std::ranges::find(parts_, static_cast<int>(part)) != parts_.end())
      for (const auto entity : region.entities)
        if (const auto here = of_kind(region.kind)[entity]; here >= 0) entities.push_back(here);
    w.put(region.kind);
    w.put(entities);
  }
  const PartIndicators* const all = d_.space.indicators.get();
  w.put(static_cast<int>(all == nullptr ? 0 : all->parts.size()));
  for (std::size_t part = 0; all != nullptr && part < all->parts.size(); ++part) {
    const PartIndicators::Part& of = all->parts[part];
    std::vector<std::uint8_t> inside;
    for (const auto entity : of_kind(of.kind).whole)
      inside.push_back(of.inside.empty() ? std::uint8_t{0}
                                         : of.inside[static_cast<std::size_t>(entity)]);
    w.put(of.kind);
    w.put(inside);
  }
}

/// Of dofs with one entry the one that the others repeat has it, where that is here.
OwnEntries Cut::put_layout(StateWriter& w) const {
  const int components = d_.space.components;
  OwnEntries out;
  Indices dof_of, others, others_dof;
  std::vector<DofLink> links;
  std::map<std::int32_t, std::int32_t> has; // by entry that is repeated, the dof here
  for (const DofLink& link : layout_.links) has[layout_.entry_of[link.to]] = -1;
  const auto here = [&](std::int32_t dof) {
    const auto node = nodes_[dof / components];
    return node < 0 ? -1 : node * components + dof % components;
  };
  for (auto& [entry, dof] : has)
    if (entry >= 0) dof = here(layout_.dof_of[entry]);
  for (std::size_t node = 0; node < nodes_.whole.size(); ++node)
    for (int c = 0; c < components; ++c) {
      const auto entry = layout_.entry_of[d_.space.dof(nodes_.whole[node], c)];
      if (entry < 0) continue;
      const auto dof = static_cast<std::int32_t>(node) * components + c;
      if (const auto repeated = has.find(entry); repeated != has.end()) {
        if (repeated->second < 0) repeated->second = dof;
        if (repeated->second != dof) {
          links.push_back({dof, repeated->second});
          continue;
        }
      }
      (is_own(entry) ? out.state : others).push_back(entry);
      (is_own(entry) ? dof_of : others_dof).push_back(dof);
    }
  out.unknowns = static_cast<int>(out.state.size());
  out.state.insert(out.state.end(), others.begin(), others.end());
  dof_of.insert(dof_of.end(), others_dof.begin(), others_dof.end());
  w.put(out.unknowns);
  w.put(dof_of);
  w.put(links);
  return out;
}

/// The cells of its domain, which is made of them when the nodes are there.
Indices get_block(StateReader& r, SpaceBlock& out) {
  out.name = get_text(r);
  out.first = r.get<int>();
  out.components = r.get<int>();
  out.order = r.get<int>();
  if (const int part = r.get<int>(); part >= 0) {
    auto domain = std::make_shared<SpaceDomain>();
    domain->part = part;
    out.domain = std::move(domain);
  }
  return r.get_vector<std::int32_t>();
}

void get_space(StateReader& r, Discretisation& d) {
  Space& space = d.space;
  space.mesh = &d.mesh;
  space.order = r.get<int>();
  space.components = r.get<int>();
  std::vector<Indices> domains;
  space.blocks.resize(static_cast<std::size_t>(r.get<int>()));
  for (SpaceBlock& block : space.blocks) domains.push_back(get_block(r, block));
  space.nodes = r.get_vector<Point>();
  space.cell_nodes = r.get_vector<std::int32_t>();
  space.facet_nodes = r.get_vector<std::int32_t>();
  const int dim = d.mesh.dim; // as many edges as pairs of corners
  space.nodes_per_cell = space.order == 1 ? dim + 1 : (dim + 1) * (dim + 2) / 2;
  space.nodes_per_facet = space.order == 1 ? dim : dim * (dim + 1) / 2;
  space.graph = std::make_shared<const NodeGraph>(
      make_node_graph(space.nodes.size(), space.cell_nodes, space.nodes_per_cell));
  for (std::size_t b = 0; b < space.blocks.size(); ++b)
    if (space.blocks[b].domain)
      space.blocks[b].domain = domain_of_cells(space, {Group::Kind::cells, std::move(domains[b])},
                                               space.blocks[b].domain->part);
}

void get_regions(StateReader& r, Discretisation& d) {
  d.parts.resize(static_cast<std::size_t>(r.get<int>()));
  for (Region& region : d.parts) {
    region.kind = r.get<Group::Kind>();
    region.entities = r.get_vector<std::int32_t>();
  }
  auto indicators = std::make_shared<PartIndicators>();
  indicators->parts.resize(static_cast<std::size_t>(r.get<int>()));
  for (auto& part : indicators->parts) {
    part.kind = r.get<Group::Kind>();
    part.inside = r.get_vector<std::uint8_t>();
  }
  if (!indicators->parts.empty()) d.space.indicators = std::move(indicators);
}

void get_layout(StateReader& r, const Space& space, StateLayout& out) {
  out.n_unknowns = r.get<int>();
  out.dof_of = r.get_vector<std::int32_t>();
  out.links = r.get_vector<DofLink>();
  out.n_state = static_cast<int>(out.dof_of.size());
  out.n_dofs = space.n_dofs();
  out.entry_of.assign(static_cast<std::size_t>(out.n_dofs), -1);
  for (int entry = 0; entry < out.n_state; ++entry) out.entry_of[out.dof_of[entry]] = entry;
  for (const DofLink& link : out.links) out.entry_of[link.dof] = out.entry_of[link.to];
}

/// Neighbours without the vertex itself, of the nodes that are chosen.
void graph_of(const NodeGraph& graph, const Chosen& nodes, std::vector<idx_t>& start,
              std::vector<idx_t>& neighbours) {
  start.assign(1, 0);
  for (const auto node : nodes.whole) {
    for (auto k = graph.offsets[node]; k < graph.offsets[node + 1]; ++k)
      if (const auto other = nodes[graph.neighbours[k]]; other >= 0 && graph.neighbours[k] != node)
        neighbours.push_back(other);
    start.push_back(static_cast<idx_t>(neighbours.size()));
  }
}

} // namespace

std::vector<std::int32_t> parts_of_nodes(const Space& space, const StateLayout& layout, int parts) {
  std::vector<char> has_unknown(space.nodes.size(), 0);
  for (int i = 0; i < layout.n_unknowns; ++i) has_unknown[layout.dof_of[i] / space.components] = 1;
  const Chosen nodes(has_unknown);
  auto vertices = static_cast<idx_t>(nodes.whole.size());
  std::vector<idx_t> start, neighbours, part(nodes.whole.size());
  if (parts == 1 || vertices < few_nodes * parts) {
    for (idx_t v = 0; v < vertices; ++v)
      part[v] = static_cast<idx_t>(static_cast<std::int64_t>(v) * parts / vertices);
  } else {
    graph_of(*space.graph, nodes, start, neighbours);
    idx_t constraints = 1, wanted = parts, cut = 0;
    const std::scoped_lock lock(metis_turn());
    const int answer = METIS_PartGraphKway(&vertices, &constraints, start.data(), neighbours.data(),
                                           nullptr, nullptr, nullptr, &wanted, nullptr, nullptr,
                                           nullptr, &cut, part.data());
    if (answer == METIS_ERROR_MEMORY) throw std::bad_alloc();
    if (answer != METIS_OK)
      throw Failure(FailureKind::output, {}, "METIS finds no parts of the mesh",
                    "take one process");
  }
  std::vector<std::int32_t> out(space.nodes.size(), 0);
  for (std::size_t v = 0; v < part.size(); ++v) out[nodes.whole[v]] = part[v];
  return out;
}

OwnEntries put_own_cells(StateWriter& w, const Discretisation& discretisation,
                         const StateLayout& layout, std::span<const std::int32_t> part_of_node,
                         int p, std::span<const int> parts, std::span<const std::int32_t> also) {
  const Cut cut(discretisation, layout, part_of_node, p, parts, also);
  cut.put_mesh(w);
  cut.put_space(w);
  cut.put_regions(w);
  OwnEntries out = cut.put_layout(w);
  out.cells = cut.cells();
  return out;
}

void get_own_cells(StateReader& r, OwnCells& out) {
  Discretisation& d = out.discretisation;
  d.mesh.dim = r.get<int>();
  d.mesh.axisymmetric = r.get<bool>();
  d.mesh.nodes = r.get_vector<Point>();
  d.mesh.cells = r.get_vector<std::array<std::int32_t, 4>>();
  d.mesh.facets = r.get_vector<Facet>();
  get_space(r, d);
  get_regions(r, d);
  get_layout(r, d.space, out.layout);
}

} // namespace hvi::solver
