// See fields.hpp.
#include "lang/python/fields.hpp"

#include "solver/fem/element.hpp"
#include "solver/results/field_files.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace hvi::python {

namespace {

const char* name_of(solver::VtkCell cell) {
  using C = solver::VtkCell;
  switch (cell) {
  case C::line:
    return "line";
  case C::triangle:
    return "triangle";
  case C::tetra:
    return "tetra";
  case C::quadratic_edge:
    return "line3";
  case C::quadratic_triangle:
    return "triangle6";
  case C::quadratic_tetra:
    return "tetra10";
  case C::vertex:
    break;
  }
  return "vertex";
}

std::vector<std::int64_t> shape_of(std::size_t nodes, int components) {
  std::vector<std::int64_t> out{static_cast<std::int64_t>(nodes)};
  if (components > 1) out.push_back(components);
  return out;
}

/// The middles of edges get the mean of their ends.
void fill_edges(const solver::Space& space, const solver::SpaceBlock& block,
                std::vector<double>& values) {
  const int dim = space.mesh->dim, components = block.components;
  const auto& edges = solver::simplex_edges(dim);
  const auto at = [&](std::int32_t node, int c) -> double& {
    return values[static_cast<std::size_t>(node) * static_cast<std::size_t>(components) +
                  static_cast<std::size_t>(c)];
  };
  for (int cell = 0; cell < static_cast<int>(space.mesh->cells.size()); ++cell) {
    if (!block.lives_in(cell)) continue;
    const auto nodes = space.nodes_of_cell(cell);
    for (std::size_t e = 0; e < edges.size(); ++e)
      for (int c = 0; c < components; ++c)
        at(nodes[static_cast<std::size_t>(dim) + 1 + e], c) =
            0.5 * (at(nodes[static_cast<std::size_t>(edges[e][0])], c) +
                   at(nodes[static_cast<std::size_t>(edges[e][1])], c));
  }
}

/// An unknown on a part of the mesh has no values at nodes outside of it.
void clear_outside(const solver::Space& space, const solver::SpaceBlock& block,
                   std::vector<double>& values) {
  std::vector<char> inside(space.nodes.size(), 0);
  for (int cell = 0; cell < static_cast<int>(space.mesh->cells.size()); ++cell)
    if (block.lives_in(cell))
      for (const std::int32_t node : space.nodes_of_cell(cell))
        inside[static_cast<std::size_t>(node)] = 1;
  const auto each = static_cast<std::size_t>(block.components);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (inside[i / each] == 0) values[i] = std::numeric_limits<double>::quiet_NaN();
}

} // namespace

Grid grid_of(const solver::Space& space) {
  const solver::VtuGrid grid = solver::body_grid(space);
  Grid out;
  out.cell = name_of(grid.cell);
  out.nodes_per_cell = solver::nodes_of(grid.cell);
  out.cells = grid.connectivity;
  const int dim = space.mesh->dim;
  out.points = {"points", {static_cast<std::int64_t>(grid.points.size()), dim}, {}};
  for (const solver::Point& p : grid.points)
    out.points.values.insert(out.points.values.end(), p.begin(), p.begin() + dim);
  return out;
}

std::vector<Array> unknowns_of(const solver::Space& space, const solver::Vector& u) {
  std::vector<Array> out;
  for (const solver::SpaceBlock& block : space.blocks) {
    Array one{block.name, shape_of(space.nodes.size(), block.components), {}};
    for (int node = 0; node < static_cast<int>(space.nodes.size()); ++node)
      for (int c = 0; c < block.components; ++c)
        one.values.push_back(u[space.dof(node, block.first + c)]);
    if (block.order < space.order) fill_edges(space, block, one.values);
    if (block.domain != nullptr) clear_outside(space, block, one.values);
    out.push_back(std::move(one));
  }
  return out;
}

std::size_t show_fields(solver::Plan& plan) {
  auto& report = plan.report;
  const std::size_t before = report.pictures.size();
  for (const solver::FieldsSpec& files : report.fields)
    for (const solver::FieldSpec& field : files.fields) {
      solver::PictureSpec picture;
      picture.field = field;
      picture.in_row = -1;
      report.pictures.push_back(std::move(picture));
    }
  return before;
}

std::vector<Array> shown_fields(const solver::Plan& plan, std::size_t first,
                                const solver::RunResult& result) {
  std::vector<Array> out;
  for (std::size_t i = first; i < plan.report.pictures.size() && i < result.pictures.size(); ++i) {
    const auto& field = plan.report.pictures[i].field;
    const auto& values = result.pictures[i].values;
    if (values.empty()) continue; // it lives at the points of a law, or the run ended before
    const auto components = field.components.size();
    out.push_back(
        {field.name, shape_of(values.size() / components, static_cast<int>(components)), values});
  }
  return out;
}

} // namespace hvi::python
