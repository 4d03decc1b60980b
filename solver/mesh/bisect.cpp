// Bisection of simplices; see bisect.hpp.
#include "solver/mesh/bisect.hpp"

#include "solver/mesh/generate.hpp"
#include "solver/mesh/limits.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace hvi::solver {
namespace {

std::uint64_t key(const std::array<std::int32_t, 2>& edge) {
  return static_cast<std::uint64_t>(edge[0]) << 32 | static_cast<std::uint64_t>(edge[1]);
}

std::array<std::int32_t, 2> sorted(std::int32_t a, std::int32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Nodes of the face opposite local node `i`.
std::array<std::int32_t, 3> face(const std::array<std::int32_t, 4>& nodes, int i) {
  std::array<std::int32_t, 3> out{};
  for (int k = 0, n = 0; k < 4; ++k)
    if (k != i) out[n++] = nodes[k];
  return out;
}

bool has(const std::array<std::int32_t, 2>& edge, std::int32_t node) {
  return edge[0] == node || edge[1] == node;
}

} // namespace

Bisection::Bisection(const Mesh& first) : first_(first), nodes_(first.nodes) {
  cells_.reserve(first.cells.size());
  const auto n = static_cast<std::size_t>(first.dim) + 1;
  for (const auto& nodes : first.cells) {
    Cell cell{nodes};
    cell.cut = longest({nodes.data(), n});
    cell.first = static_cast<std::int32_t>(cells_.size());
    for (int i = 0; first.dim == 3 && i < 4; ++i) cell.marks[i] = longest(face(nodes, i));
    cells_.push_back(cell);
  }
}

/// The longest edge. Its length is computed from the sorted nodes, to the same bits in every cell,
/// and equal lengths are told apart by the nodes: a face has the same edge seen from both its
/// cells.
Bisection::Edge Bisection::longest(std::span<const std::int32_t> nodes) const {
  Edge best{-1, -1};
  double most = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = i + 1; j < nodes.size(); ++j) {
      const Edge edge = sorted(nodes[i], nodes[j]);
      const Point &a = nodes_[edge[0]], &b = nodes_[edge[1]];
      const double length = (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                            (a[2] - b[2]) * (a[2] - b[2]);
      if (best[0] < 0 || std::tie(length, edge) > std::tie(most, best)) most = length, best = edge;
    }
  return best;
}

std::int32_t Bisection::known_midpoint(const Edge& edge) const {
  const auto at = midpoints_.find(key(edge));
  return at == midpoints_.end() ? -1 : at->second;
}

std::int32_t Bisection::midpoint(const Edge& edge) {
  const auto [at, fresh] =
      midpoints_.try_emplace(key(edge), static_cast<std::int32_t>(nodes_.size()));
  if (fresh) {
    const Point a = nodes_[edge[0]], b = nodes_[edge[1]];
    nodes_.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
  }
  return at->second;
}

bool Bisection::hangs(const Cell& cell) const {
  for (int i = 0; i <= first_.dim; ++i)
    for (int j = i + 1; j <= first_.dim; ++j)
      if (known_midpoint(sorted(cell.nodes[i], cell.nodes[j])) >= 0) return true;
  return false;
}

/// Child a keeps cut[0], child b keeps cut[1]; the other end becomes the midpoint m, which keeps
/// the orientation.
void Bisection::cut(std::int32_t number) {
  ++cells_[number].cuts;
  const Cell parent = cells_[number];
  const std::int32_t m = midpoint(parent.cut);
  Cell a = parent, b = parent;
  std::replace(a.nodes.begin(), a.nodes.end(), parent.cut[1], m);
  std::replace(b.nodes.begin(), b.nodes.end(), parent.cut[0], m);
  if (first_.dim == 3) {
    mark_children(parent, m, a, b);
  } else {
    // Newest vertex: the edge opposite the new node.
    for (Cell* child : {&a, &b}) {
      std::array<std::int32_t, 2> rest{};
      int n = 0;
      for (int i = 0; i <= first_.dim; ++i)
        if (child->nodes[i] != m) rest[n++] = child->nodes[i];
      child->cut = n == 2 ? sorted(rest[0], rest[1]) : sorted(rest[0], m);
    }
  }
  cells_[number] = a;
  cells_.push_back(b);
}

/// The rules of Arnold, Mukherjee and Pouly (bisect.hpp), section 2.
void Bisection::mark_children(const Cell& parent, std::int32_t m, Cell& a, Cell& b) const {
  const Edge& cut = parent.cut;
  Edge inherited_a{}, inherited_b{}; // marks of the two faces that are not cut
  for (int i = 0; i < 4; ++i) {
    if (parent.nodes[i] == cut[1]) inherited_a = parent.marks[i];
    if (parent.nodes[i] == cut[0]) inherited_b = parent.marks[i];
  }
  Edge rest{-1, -1}; // the edge opposite the cut
  for (const std::int32_t node : parent.nodes)
    if (!has(cut, node)) (rest[0] < 0 ? rest[0] : rest[1]) = node;
  rest = sorted(rest[0], rest[1]);
  // Planar: all marks lie in one face with the cut, so the three have three nodes together.
  const auto apex = [&](const Edge& mark, std::int32_t end) { // the other node of a mark at `end`
    return mark == rest || !has(mark, end) ? -1 : mark[0] == end ? mark[1] : mark[0];
  };
  const std::int32_t at_a = apex(inherited_a, cut[0]), at_b = apex(inherited_b, cut[1]);
  const bool planar = at_a >= 0 && at_a == at_b;
  const Edge between = planar && parent.flag ? sorted(m, at_a) : rest;
  const auto fill = [&](Cell& child, const Edge& inherited, std::int32_t kept) {
    child.cut = inherited;
    child.flag = planar && !parent.flag;
    for (int i = 0; i < 4; ++i) {
      const std::int32_t node = child.nodes[i];
      if (node == m) child.marks[i] = inherited;  // the face of the parent
      if (node == kept) child.marks[i] = between; // the new face
      if (node != m && node != kept)              // a half of a cut face: opposite the new node
        child.marks[i] = sorted(kept, node == rest[0] ? rest[1] : rest[0]);
    }
  };
  fill(a, inherited_a, cut[0]);
  fill(b, inherited_b, cut[1]);
}

/// The cells as mesh() numbers them: those of a piece stand together.
std::vector<std::int32_t> Bisection::in_order() const {
  std::vector<std::int32_t> out(cells_.size());
  std::iota(out.begin(), out.end(), 0);
  if (!first_.pieces.empty())
    std::ranges::stable_sort(out, {}, [&](std::int32_t cell) {
      return first_.piece_of_cell(cells_[static_cast<std::size_t>(cell)].first);
    });
  return out;
}

void Bisection::bisect(std::span<const std::int32_t> cells, int times) {
  const auto order = in_order();
  for (const std::int32_t number : cells) {
    Cell& cell = cells_[static_cast<std::size_t>(order[static_cast<std::size_t>(number)])];
    cell.due = cell.cuts + times;
  }
  // A cell with a node in the middle of an edge is cut, at its own edge, until none has one.
  for (bool changed = true; changed;) {
    changed = false;
    const auto n = static_cast<std::int32_t>(cells_.size());
    for (std::int32_t i = 0; i < n; ++i)
      if (cells_[i].cuts < cells_[i].due || hangs(cells_[i])) cut(i), changed = true;
    check_cell_limit(static_cast<double>(cells_.size()));
  }
}

/// What became of a facet of the first mesh, in its orientation.
void Bisection::pieces(const std::array<std::int32_t, 3>& facet, const Edge& cut,
                       std::vector<std::array<std::int32_t, 3>>& out) const {
  const std::int32_t m = first_.dim == 1 ? -1 : known_midpoint(cut);
  if (m < 0) {
    out.push_back(facet);
    return;
  }
  auto a = facet, b = facet;
  std::replace(a.begin(), a.end(), cut[1], m);
  std::replace(b.begin(), b.end(), cut[0], m);
  const auto next = [&](const std::array<std::int32_t, 3>& child) {
    Edge rest{-1, -1};
    for (int i = 0; i < first_.dim; ++i)
      if (child[i] != m) (rest[0] < 0 ? rest[0] : rest[1]) = child[i];
    return first_.dim == 2 ? sorted(rest[0], m) : sorted(rest[0], rest[1]);
  };
  pieces(a, next(a), out);
  pieces(b, next(b), out);
}

Mesh Bisection::mesh() const {
  Mesh out;
  out.dim = first_.dim;
  out.axisymmetric = first_.axisymmetric;
  out.nodes = nodes_;
  out.description = first_.description + ", bisected";
  std::vector<std::vector<std::int32_t>> children(first_.cells.size());
  for (const std::int32_t number : in_order()) {
    const Cell& cell = cells_[static_cast<std::size_t>(number)];
    const auto now = static_cast<std::int32_t>(out.cells.size());
    if (out.pieces.size() < first_.pieces.size() && cell.first >= first_.pieces[out.pieces.size()])
      out.pieces.push_back(now);
    children[cell.first].push_back(now);
    out.cells.push_back(out.dim == 3 ? refinable_order(nodes_, cell.nodes) : cell.nodes);
  }
  std::vector<std::array<std::int32_t, 3>> facets;
  std::vector<std::size_t> past;
  for (const Facet& facet : first_.facets) {
    const std::span<const std::int32_t> nodes(facet.nodes.data(),
                                              static_cast<std::size_t>(out.dim));
    pieces(facet.nodes, out.dim == 1 ? Edge{} : longest(nodes), facets);
    past.push_back(facets.size());
  }
  const auto named = build_facets(out, facets);
  for (const auto& [name, group] : first_.groups) {
    Group& target = out.groups[name];
    target.kind = group.kind;
    target.of_lines = group.of_lines;
    target.against_another = group.against_another;
    for (const std::int32_t e : group.entities) {
      if (group.kind == Group::Kind::points) target.entities.push_back(e);
      if (group.kind == Group::Kind::cells)
        target.entities.insert(target.entities.end(), children[e].begin(), children[e].end());
      if (group.kind == Group::Kind::facets)
        for (std::size_t f = e == 0 ? 0 : past[e - 1]; f < past[e]; ++f)
          target.entities.push_back(named[f]);
    }
    std::sort(target.entities.begin(), target.entities.end());
  }
  return out;
}

} // namespace hvi::solver
