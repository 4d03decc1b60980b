// From cells to facets: which are on the boundary, which lie between two cells. Between the mesh
// sources (generate, read_msh, gmsh) and everything that integrates over a boundary.
#include "solver/common/failure.hpp"
#include "solver/common/joined.hpp"
#include "solver/mesh/facet_table.hpp"
#include "solver/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

namespace hvi::solver {
namespace {

std::string place(const Mesh& mesh, const std::array<std::int32_t, 3>& nodes) {
  std::string text;
  for (int i = 0; i < mesh.nodes_per_facet(); ++i) {
    const auto& p = mesh.nodes[nodes[i]];
    text += fmt::format("{}({})", i ? ", " : "", joined(p, mesh.dim, 6));
  }
  return text;
}

Failure bad(const Mesh& mesh, const std::array<std::int32_t, 3>& nodes, const std::string& what) {
  return Failure(FailureKind::bad_mesh, {},
                 fmt::format("{} (corners {})", what, place(mesh, nodes)));
}

/// A run of sides is a facet: one side, or two that see it from opposite sides.
void check_run(const Mesh& mesh, const FacetTable& table, FacetTable::Run run) {
  const auto& side = table.sides();
  const auto [begin, end] = run;
  const auto nodes = local_facet(mesh.dim, mesh.cells[side[begin].cell], side[begin].local);
  if (end - begin > 2)
    throw bad(mesh, nodes,
              fmt::format("{} cells share one facet, only 2 can: the cells overlap", end - begin));
  if (end - begin == 2 && side[begin].odd == side[begin + 1].odd)
    throw bad(
        mesh, nodes,
        fmt::format("cells {} and {} lie on the same side of their common facet: they overlap",
                    side[begin].cell, side[begin + 1].cell));
}

Facet make_facet(const Mesh& mesh, const FacetTable::Side& side, std::int32_t other) {
  return {local_facet(mesh.dim, mesh.cells[side.cell], side.local), side.cell, other};
}

} // namespace

std::array<std::int32_t, 3> local_facet(int dim, const std::array<std::int32_t, 4>& cell,
                                        int local) {
  static constexpr std::int8_t triangle[3][2] = {{1, 2}, {2, 0}, {0, 1}};
  static constexpr std::int8_t tetrahedron[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  if (dim == 1) return {cell[1 - local], -1, -1};
  if (dim == 2) return {cell[triangle[local][0]], cell[triangle[local][1]], -1};
  return {cell[tetrahedron[local][0]], cell[tetrahedron[local][1]], cell[tetrahedron[local][2]]};
}

void turn(int dim, std::array<std::int32_t, 3>& nodes) {
  if (dim > 1) std::swap(nodes[0], nodes[1]);
}

FacetKey facet_key(int dim, std::array<std::int32_t, 3> n) {
  bool odd = false;
  const auto order = [&](int i, int j) {
    if (n[i] > n[j]) {
      std::swap(n[i], n[j]);
      odd = !odd;
    }
  };
  if (dim >= 2) order(0, 1);
  if (dim == 3) {
    order(1, 2);
    order(0, 1);
  }
  return {n, odd};
}

namespace {

/// Calls visit(cell, local, nodes) for every side of every cell whose nodes are all flagged.
template <class Visit>
void for_each_side(const Mesh& mesh, std::span<const char> among, const Visit& visit) {
  const int corners = mesh.dim + 1;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const auto& cell = mesh.cells[c];
    const auto flagged = [&](std::int32_t node) { return among.empty() || among[node] != 0; };
    const auto held = std::count_if(cell.begin(), cell.begin() + corners, flagged);
    for (int local = 0; local < corners && held >= mesh.dim; ++local)
      if (held == corners || !flagged(cell[local]))
        visit(c, local, local_facet(mesh.dim, cell, local));
  }
}

} // namespace

// A counting sort by the smallest node, then a sort of each small bucket: the whole is linear in
// practice (about 24 sides a bucket in 3D) and touches memory in order.
FacetTable::FacetTable(const Mesh& mesh, std::span<const char> among)
    : first_(mesh.nodes.size() + 1, 0) {
  for_each_side(mesh, among, [&](std::size_t, int, const auto& nodes) {
    ++first_[*std::min_element(nodes.begin(), nodes.begin() + mesh.dim) + 1];
  });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  sides_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for_each_side(mesh, among, [&](std::size_t c, int local, const auto& nodes) {
    FacetKey key = facet_key(mesh.dim, nodes);
    // A point has no orientation of its own: the right end of a cell counts as even.
    if (mesh.dim == 1) key.odd = local == 1;
    sides_[next[key.nodes[0]]++] = {key.nodes[1], key.nodes[2], static_cast<std::int32_t>(c),
                                    static_cast<std::int8_t>(local), key.odd};
  });
  for (std::size_t n = 0; n + 1 < first_.size(); ++n) {
    std::sort(sides_.begin() + first_[n], sides_.begin() + first_[n + 1],
              [](const Side& a, const Side& b) {
                return std::tie(a.second, a.third, a.cell) < std::tie(b.second, b.third, b.cell);
              });
  }
}

std::size_t FacetTable::run_end(std::size_t begin, std::size_t bucket_end) const {
  const Side& s = sides_[begin];
  std::size_t end = begin + 1;
  while (end < bucket_end && sides_[end].second == s.second && sides_[end].third == s.third) ++end;
  return end;
}

FacetTable::Run FacetTable::find(const FacetKey& key) const {
  const std::size_t bucket_end = first_[key.nodes[0] + 1];
  const auto at =
      std::lower_bound(sides_.begin() + first_[key.nodes[0]],
                       sides_.begin() + static_cast<std::ptrdiff_t>(bucket_end), key,
                       [](const Side& s, const FacetKey& k) {
                         return std::tie(s.second, s.third) < std::tie(k.nodes[1], k.nodes[2]);
                       });
  const auto begin = static_cast<std::size_t>(at - sides_.begin());
  if (begin == bucket_end || at->second != key.nodes[1] || at->third != key.nodes[2])
    return {begin, begin};
  return {begin, run_end(begin, bucket_end)};
}

std::vector<std::int32_t> index_facets(Mesh& mesh,
                                       const std::vector<std::array<std::int32_t, 3>>& named,
                                       std::span<const char> among) {
  const FacetTable table(mesh, among);
  const auto& sides = table.sides();
  std::vector<std::int32_t> facet_at(named.empty() ? 0 : sides.size(), -1); // by begin of a run
  mesh.facets.clear();
  table.for_each([&](FacetTable::Run run) {
    check_run(mesh, table, run);
    if (run.end - run.begin != 1) return;
    if (!named.empty()) facet_at[run.begin] = static_cast<std::int32_t>(mesh.facets.size());
    mesh.facets.push_back(make_facet(mesh, sides[run.begin], -1));
  });

  std::vector<std::int32_t> index(named.size(), -1);
  for (std::size_t i = 0; i < named.size(); ++i) {
    const FacetKey key = facet_key(mesh.dim, named[i]);
    const auto run = table.find(key);
    if (run.begin == run.end) continue;
    if (facet_at[run.begin] < 0) {
      facet_at[run.begin] = static_cast<std::int32_t>(mesh.facets.size());
      const bool swap = sides[run.begin].odd != key.odd;
      const auto& near = sides[run.begin + (swap ? 1 : 0)];
      const auto& far = sides[run.begin + (swap ? 0 : 1)];
      mesh.facets.push_back(make_facet(mesh, near, far.cell));
    }
    index[i] = facet_at[run.begin];
  }
  return index;
}

std::vector<std::int32_t> build_facets(Mesh& mesh,
                                       const std::vector<std::array<std::int32_t, 3>>& named) {
  auto index = index_facets(mesh, named);
  for (std::size_t i = 0; i < named.size(); ++i)
    if (index[i] < 0) throw bad(mesh, named[i], "a named facet is not a facet of any cell");
  return index;
}

std::vector<std::int32_t> pieces_of(const Mesh& mesh) {
  std::vector<std::int32_t> parent(mesh.cells.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t c) {
    while (parent[c] != c) c = parent[c] = parent[parent[c]];
    return c;
  };
  const FacetTable table(mesh);
  table.for_each([&](FacetTable::Run run) {
    for (std::size_t i = run.begin + 1; i < run.end; ++i) {
      const auto a = root(table.sides()[run.begin].cell), b = root(table.sides()[i].cell);
      parent[std::max(a, b)] = std::min(a, b);
    }
  });
  // The root of a piece is its smallest cell, so pieces are numbered by first appearance.
  std::vector<std::int32_t> piece(mesh.cells.size());
  std::int32_t pieces = 0;
  for (std::size_t c = 0; c < piece.size(); ++c) {
    const auto r = root(static_cast<std::int32_t>(c));
    piece[c] = r == static_cast<std::int32_t>(c) ? pieces++ : piece[r];
  }
  return piece;
}

} // namespace hvi::solver
