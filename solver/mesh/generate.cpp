// Structured meshes of intervals, rectangles and boxes.
#include "solver/mesh/generate.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/joined.hpp"
#include "solver/mesh/facet_table.hpp"
#include "solver/mesh/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace hvi::solver {
namespace {

/// The grid behind a structured mesh: nodes lexicographic, x fastest.
struct Grid {
  int dim;
  std::array<std::int32_t, 3> cells{1, 1, 1}, nodes{1, 1, 1};

  bool crossed = false;
  std::int32_t node(int i, int j, int k) const { return (k * nodes[1] + j) * nodes[0] + i; }
  std::int32_t middle(int i, int j) const { return nodes[0] * nodes[1] + j * cells[0] + i; }
};

void check_lines(int axis, const std::vector<double>& x) {
  const char name = "xyz"[axis];
  if (x.size() < 2)
    throw Failure(
        FailureKind::bad_value, {},
        fmt::format("a mesh needs at least 2 grid lines along {}, not {}", name, x.size()));
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]))
      throw Failure(FailureKind::bad_value, {},
                    fmt::format("a grid line along {} is {}", name, x[i]));
    if (i > 0 && !(x[i] > x[i - 1]))
      throw Failure(FailureKind::bad_value, {},
                    fmt::format("grid lines along {} must increase: {} comes after {}", name, x[i],
                                x[i - 1]));
  }
}

Grid make_grid(int dim, const std::array<std::vector<double>, 3>& lines, bool crossed) {
  Grid grid{dim};
  grid.crossed = crossed;
  double cells = dim == 3 ? 6 : crossed ? 4 : dim;
  for (int a = 0; a < dim; ++a) {
    check_lines(a, lines[a]);
    cells *= static_cast<double>(lines[a].size() - 1);
    check_cell_limit(cells);
    grid.nodes[a] = static_cast<std::int32_t>(lines[a].size());
    grid.cells[a] = grid.nodes[a] - 1;
  }
  return grid;
}

void add_rectangle(const Grid& g, int i, int j, Mesh& mesh) {
  const auto sw = g.node(i, j, 0), se = g.node(i + 1, j, 0);
  const auto nw = g.node(i, j + 1, 0), ne = g.node(i + 1, j + 1, 0);
  if (g.crossed) {
    const auto middle = g.middle(i, j);
    for (const auto& [a, b] : {std::pair{sw, se}, {se, ne}, {ne, nw}, {nw, sw}})
      mesh.cells.push_back({a, b, middle, -1});
    return;
  }
  mesh.cells.push_back({sw, se, ne, -1});
  mesh.cells.push_back({sw, ne, nw, -1});
}

/// Kuhn's triangulation (H. W. Kuhn, Some combinatorial lemmas in topology, IBM J. Res. Dev. 4
/// (1960) 518-524): the tetrahedra are the paths from the low to the high corner along the axes,
/// one for each order of the axes. An odd order gives a negative tetrahedron: it is stored reversed
/// with its middle nodes swapped, as refine() expects, which recovers the path order.
void add_box(const Grid& g, int i, int j, int k, Mesh& mesh) {
  static constexpr int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                       {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  static constexpr bool odd[6] = {false, true, true, false, false, true};
  for (int o = 0; o < 6; ++o) {
    std::array<int, 3> at{i, j, k};
    std::array<std::int32_t, 4> path;
    path[0] = g.node(at[0], at[1], at[2]);
    for (int step = 0; step < 3; ++step) {
      ++at[orders[o][step]];
      path[step + 1] = g.node(at[0], at[1], at[2]);
    }
    if (odd[o]) path = {path[3], path[1], path[2], path[0]};
    mesh.cells.push_back(path);
  }
}

void add_cells(const Grid& g, Mesh& mesh) {
  for (int k = 0; k < g.cells[2]; ++k) {
    for (int j = 0; j < g.cells[1]; ++j) {
      for (int i = 0; i < g.cells[0]; ++i) {
        if (g.dim == 1) mesh.cells.push_back({i, i + 1, -1, -1});
        if (g.dim == 2) add_rectangle(g, i, j, mesh);
        if (g.dim == 3) add_box(g, i, j, k, mesh);
      }
    }
  }
}

/// Groups: a facet belongs to a side when all its nodes have the first or last index of an axis.
void name_sides(const Grid& g, Mesh& mesh) {
  static const char* const names[3][2] = {{"left", "right"}, {"bottom", "top"}, {"back", "front"}};
  const auto index = [&](std::int32_t node, int axis) {
    if (axis == 0) return node % g.nodes[0];
    if (axis == 1) return node / g.nodes[0] % g.nodes[1];
    return node / g.nodes[0] / g.nodes[1];
  };
  for (int axis = 0; axis < g.dim; ++axis)
    for (const char* name : names[axis]) mesh.groups[name].kind = Group::Kind::facets;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const auto& nodes = mesh.facets[f].nodes;
    for (int axis = 0; axis < g.dim; ++axis) {
      for (int side = 0; side < 2; ++side) {
        const std::int32_t wanted = side == 0 ? 0 : g.nodes[axis] - 1;
        if (std::all_of(nodes.begin(), nodes.begin() + g.dim,
                        [&](std::int32_t n) { return index(n, axis) == wanted; }))
          mesh.groups[names[axis][side]].entities.push_back(static_cast<std::int32_t>(f));
      }
    }
  }
}

std::string describe(const Grid& g, const std::array<std::vector<double>, 3>& lines) {
  static const char* const kinds[3] = {"interval", "rectangle", "box"};
  std::string text = fmt::format("{} ", kinds[g.dim - 1]);
  for (int a = 0; a < g.dim; ++a)
    text += fmt::format("{}({:.6g}, {:.6g})", a ? " x " : "", lines[a].front(), lines[a].back());
  text += fmt::format(", cells = [{}]",
                      joined(std::span(g.cells).first(static_cast<std::size_t>(g.dim))));
  return g.crossed ? text + ", crossed" : text;
}

} // namespace

void check_cell_limit(double cells) {
  if (cells > max_cells)
    throw Failure(
        FailureKind::limit, {},
        fmt::format("the mesh would have {:.0f} cells; the limit is {:.0f}", cells, max_cells),
        "use fewer cells or refinements");
}

Mesh structured_mesh(int dim, const std::array<std::vector<double>, 3>& coordinates, bool crossed) {
  if (dim < 1 || dim > 3)
    throw Failure(FailureKind::bad_value, {},
                  fmt::format("a mesh has dimension 1, 2 or 3, not {}", dim));
  const Grid grid = make_grid(dim, coordinates, crossed && dim == 2);
  Mesh mesh;
  mesh.dim = dim;
  const auto line = [&](int axis, int i) { return axis < dim ? coordinates[axis][i] : 0.0; };
  mesh.nodes.reserve(static_cast<std::size_t>(grid.nodes[0]) * grid.nodes[1] * grid.nodes[2]);
  std::vector<char> outer; // is a node on the boundary?
  outer.reserve(mesh.nodes.capacity());
  const auto at_end = [&](int axis, int i) {
    return axis < dim && (i == 0 || i + 1 == grid.nodes[axis]);
  };
  for (int k = 0; k < grid.nodes[2]; ++k)
    for (int j = 0; j < grid.nodes[1]; ++j)
      for (int i = 0; i < grid.nodes[0]; ++i) {
        mesh.nodes.push_back({line(0, i), line(1, j), line(2, k)});
        outer.push_back(at_end(0, i) || at_end(1, j) || at_end(2, k));
      }
  for (int j = 0; grid.crossed && j < grid.cells[1]; ++j)
    for (int i = 0; i < grid.cells[0]; ++i)
      mesh.nodes.push_back(
          {(line(0, i) + line(0, i + 1)) / 2, (line(1, j) + line(1, j + 1)) / 2, 0.0});
  add_cells(grid, mesh);
  outer.resize(mesh.nodes.size(), 0); // those in the middle of a cell
  index_facets(mesh, {}, outer);
  name_sides(grid, mesh);
  mesh.description = describe(grid, coordinates);
  return mesh;
}

std::vector<double> uniform_coordinates(double low, double high, int cells) {
  if (cells < 1)
    throw Failure(FailureKind::bad_value, {},
                  fmt::format("a mesh needs at least 1 cell, not {}", cells));
  check_cell_limit(cells);
  std::vector<double> x(static_cast<std::size_t>(cells) + 1);
  for (int i = 0; i <= cells; ++i) x[i] = low + (high - low) * i / cells;
  x.back() = high;
  return x;
}

} // namespace hvi::solver
