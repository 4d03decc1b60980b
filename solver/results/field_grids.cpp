// See field_grids.hpp.
#include "solver/results/field_grids.hpp"

#include "solver/discrete/fields_read.hpp"
#include "solver/fem/element.hpp"
#include "solver/kernel/algebra.hpp"
#include "solver/results/absent.hpp"
#include "solver/results/table_ranges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {
namespace {

/// VTK's order of the edge nodes of a quadratic simplex.
const std::vector<std::array<int, 2>>& vtk_edges(int dim) {
  static const std::vector<std::array<int, 2>> edges[] = {
      {}, {{0, 1}}, {{0, 1}, {1, 2}, {0, 2}}, {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  return edges[dim];
}

VtkCell vtk_simplex(int dim, int order) {
  static constexpr VtkCell linear[] = {VtkCell::vertex, VtkCell::line, VtkCell::triangle,
                                       VtkCell::tetra};
  static constexpr VtkCell quadratic[] = {VtkCell::vertex, VtkCell::quadratic_edge,
                                          VtkCell::quadratic_triangle, VtkCell::quadratic_tetra};
  return order == 2 ? quadratic[dim] : linear[dim];
}

/// Which local node of ours is VTK's node i.
std::vector<int> vtk_order(int dim, int order) {
  std::vector<int> out;
  for (int v = 0; v <= dim; ++v) out.push_back(v);
  if (order == 1) return out;
  const auto& ours = simplex_edges(dim);
  for (const auto& edge : vtk_edges(dim))
    out.push_back(dim + 1 +
                  static_cast<int>(std::find(ours.begin(), ours.end(), edge) - ours.begin()));
  return out;
}

void append_simplex(VtuGrid& grid, std::span<const std::int32_t> nodes,
                    const std::vector<int>& order, const std::vector<std::int64_t>& point_of_node) {
  for (const int local : order) grid.connectivity.push_back(point_of_node[nodes[local]]);
}

/// Entities of a nodal law: facets (or cells) with the nodes they use.
VtuGrid entity_grid(const Space& space, const Region& region,
                    std::vector<std::int64_t>& point_of_node) {
  VtuGrid grid;
  point_of_node.assign(space.nodes.size(), -1);
  for (const auto node : nodes_on(space, region)) {
    point_of_node[node] = static_cast<std::int64_t>(grid.points.size());
    grid.points.push_back(space.nodes[node]);
  }
  const bool facets = region.kind == Group::Kind::facets;
  const int dim = space.mesh->dim - (facets ? 1 : 0);
  if (region.kind == Group::Kind::points || dim == 0) {
    grid.cell = VtkCell::vertex;
    for (std::size_t p = 0; p < grid.points.size(); ++p)
      grid.connectivity.push_back(static_cast<std::int64_t>(p));
    return grid;
  }
  grid.cell = vtk_simplex(dim, space.order);
  const auto order = vtk_order(dim, space.order);
  for (const auto e : region.entities)
    append_simplex(grid, facets ? space.nodes_of_facet(e) : space.nodes_of_cell(e), order,
                   point_of_node);
  return grid;
}

/// Which points of a grid have a weight, of those that a sampler's points are.
std::vector<char> with_weight(const VtuGrid& grid, const LawSampler& sampler,
                              std::span<const std::int64_t> grid_point) {
  std::vector<char> out(grid.points.size(), 0);
  for (std::size_t p = 0; p < grid_point.size(); ++p)
    if (sampler.points().weight[p] > 0.0) out[static_cast<std::size_t>(grid_point[p])] = 1;
  return out;
}

/// Nodal rules have no weight at vertices of P2 on triangles and tetrahedra, nor on an axis: each
/// of these points with the middles of its edges, or with their other ends, where there is
/// something.
std::vector<std::array<std::int64_t, 2>> beside_bare_points(const VtuGrid& grid,
                                                            std::span<const char> known) {
  const auto n = static_cast<std::size_t>(nodes_of(grid.cell));
  const bool quadratic = grid.cell == VtkCell::quadratic_edge ||
                         grid.cell == VtkCell::quadratic_triangle ||
                         grid.cell == VtkCell::quadratic_tetra;
  const int dim = grid.cell == VtkCell::line || grid.cell == VtkCell::quadratic_edge ? 1
                  : n == 3 || grid.cell == VtkCell::quadratic_triangle               ? 2
                                                                                     : 3;
  std::vector<std::array<std::int64_t, 2>> out;
  if (n == 1) return out;
  const auto& edges = vtk_edges(dim);
  for (std::size_t cell = 0; cell < grid.connectivity.size(); cell += n)
    for (std::size_t e = 0; e < edges.size(); ++e)
      for (const std::size_t k : {0, 1}) {
        const auto node = [&](int i) {
          return grid.connectivity[cell + static_cast<std::size_t>(i)];
        };
        const std::int64_t bare = node(edges[e][k]), end = node(edges[e][1 - k]);
        const std::int64_t middle = quadratic ? node(dim + 1 + static_cast<int>(e)) : end;
        if (known[static_cast<std::size_t>(bare)]) continue;
        for (const std::int64_t other : {middle, end})
          if (known[static_cast<std::size_t>(other)]) {
            out.push_back({bare, other});
            break;
          }
      }
  return out;
}

/// Of n values each, those with a weight.
void divide_by(std::span<const double> weights, std::size_t n, std::span<double> values) {
  for (std::size_t g = 0; g < weights.size(); ++g)
    for (std::size_t c = 0; c < n; ++c)
      if (weights[g] > 0.0) values[g * n + c] /= weights[g];
}

/// A vertex per quadrature point.
VtuGrid point_grid(const PointBlock& points) {
  VtuGrid grid;
  grid.cell = VtkCell::vertex;
  for (std::size_t p = 0; p < points.size(); ++p) {
    grid.points.push_back(points.point(p));
    grid.connectivity.push_back(static_cast<std::int64_t>(p));
  }
  return grid;
}

} // namespace

VtuGrid body_grid(const Space& space) {
  VtuGrid grid;
  grid.points = space.nodes;
  grid.cell = vtk_simplex(space.mesh->dim, space.order);
  const auto order = vtk_order(space.mesh->dim, space.order);
  std::vector<std::int64_t> same(space.nodes.size());
  for (std::size_t i = 0; i < same.size(); ++i) same[i] = static_cast<std::int64_t>(i);
  grid.connectivity.reserve(space.cell_nodes.size());
  for (int c = 0; c < static_cast<int>(space.mesh->cells.size()); ++c)
    append_simplex(grid, space.nodes_of_cell(c), order, same);
  return grid;
}

std::vector<FieldSpec> unknown_fields(const Problem& problem, int dim) {
  std::vector<FieldSpec> out;
  bool moved = false;
  const auto all = unknowns_of(problem.space);
  for (int k = 0; k < static_cast<int>(all.size()); ++k) {
    const UnknownSpec& unknown = all[static_cast<std::size_t>(k)];
    FieldSpec field;
    field.name = unknown.vector && !moved ? displacement_array : unknown.name;
    moved = moved || unknown.vector;
    for (int i = 0; i < components_of(unknown, dim); ++i)
      field.components.push_back(
          Expr::variable(slot::field(field_of_u(0), slot::of_unknown(k, slot::value(i)))));
    out.push_back(std::move(field));
  }
  return out;
}

namespace {

/// With what matrices have across the plane.
FieldSpec in_space(FieldSpec field) {
  if (field.across.empty()) return field;
  const auto &in = field.components, &out = field.across;
  field.components = {in[0], in[1], out[1], in[2], in[3], out[2], out[1], out[2], out[0]};
  return field;
}

} // namespace

FieldGrids::FieldGrids(const Problem& problem, const Discretisation& d, const Contact& contact,
                       std::span<const FieldSpec> asked, OfStates of_states)
    : space_(d.space), contact_(contact), n_fields_(count_fields(problem)),
      grey_(of_states == OfStates::on_the_mesh) {
  std::vector<FieldSpec> fields(asked.begin(), asked.end());
  std::ranges::transform(fields, fields.begin(), in_space);
  const auto on_mesh = [&](const FieldSpec& field) {
    return of_states == OfStates::on_the_mesh && StateField::is_one(problem, contact, field);
  };
  for (const auto& field : fields)
    if (std::ranges::none_of(field.components, reads_multiplier)) body_.push_back(field);
  for (const auto& field : fields)
    if (on_mesh(field)) of_states_.emplace_back(problem, d, contact, field);
  if (!body_.empty() || !of_states_.empty()) grids_.push_back({{}, body_grid(space_)});
  for (const auto& field : fields)
    if (std::ranges::any_of(field.components, reads_multiplier) && !on_mesh(field))
      add_parts(problem, d, field);
}

/// On every part of a law, or on every part whose states it reads.
void FieldGrids::add_parts(const Problem& problem, const Discretisation& d,
                           const FieldSpec& field) {
  const auto parts = parts_of_states(problem, contact_, field.components);
  const auto name_on = [&](int part) {
    return field.name + "_" + problem.parts[static_cast<std::size_t>(part)].name;
  };
  if (parts.size() < 2) {
    auto all = on_parts_of_laws(problem, field.components);
    for (auto& here : all) {
      FieldSpec one = field;
      one.components = std::move(here);
      add_on_contact(problem, d, one, -1, field.name);
      if (all.size() > 1) grids_.back().name = name_on(contact_parts_.back().sampler.part());
    }
    return;
  }
  for (const int part : parts) add_on_contact(problem, d, field, part, name_on(part));
}

void FieldGrids::add_on_contact(const Problem& problem, const Discretisation& d,
                                const FieldSpec& field, int on, const std::string& name) {
  LawSampler sampler(problem, d, contact_, field.components, field.origin, on);
  const Region& region = d.parts[static_cast<std::size_t>(sampler.part())];
  OnContact part{field, std::move(sampler), {}};
  VtuGrid grid;
  const auto& nodes = part.sampler.nodes();
  std::vector<std::int64_t> point_of_node;
  if (part.sampler.in_body()) {
    grid = entity_grid(d.space, region, point_of_node);
    for (const auto cell : part.sampler.points().cell)
      part.grid_point.push_back(std::ranges::lower_bound(region.entities, cell) -
                                region.entities.begin());
  } else if (std::ranges::all_of(nodes, [](auto node) { return node >= 0; })) {
    grid = entity_grid(d.space, region, point_of_node);
    for (const auto node : nodes) part.grid_point.push_back(point_of_node[node]);
    part.beside = beside_bare_points(grid, with_weight(grid, part.sampler, part.grid_point));
  } else {
    grid = point_grid(part.sampler.points());
    for (std::int64_t p = 0; p < part.sampler.size(); ++p) part.grid_point.push_back(p);
  }
  contact_parts_.push_back(std::move(part));
  grids_.push_back({name, std::move(grid)});
}

std::vector<Expr> FieldGrids::expressions() const {
  std::vector<Expr> out;
  for (const auto& field : body_)
    out.insert(out.end(), field.components.begin(), field.components.end());
  const auto add = [&](const FieldSpec& field) {
    out.insert(out.end(), field.components.begin(), field.components.end());
  };
  for (const auto& part : contact_parts_) add(part.field);
  for (const auto& one : of_states_) add(one.field());
  return out;
}

void FieldGrids::add_body_array(const FieldSpec& field, const Snapshot& snapshot) {
  VtuGrid& grid = grids_.front().grid;
  const auto n = static_cast<int>(field.components.size());
  const bool on_cells = std::any_of(field.components.begin(), field.components.end(),
                                    [&](const Expr& e) { return reads_gradient(e, n_fields_); });
  auto values = on_cells ? cell_values(space_, field.components, snapshot.values())
                         : nodal_values(space_, field.components, snapshot.values());
  refuse_outside_tables(field, on_cells, values, snapshot);
  if (grey_ && field.name != displacement_array) // by which bodies are deformed
    forget_where_absent(space_, field, on_cells, values);
  auto& data = on_cells ? grid.cell_data : grid.point_data;
  data.push_back(vtk_array(field.name, n, values));
  data.back().unit = field.unit;
}

/// Where the field has no value because a table has none there. What an unknown has not is no
/// place.
void FieldGrids::refuse_outside_tables(const FieldSpec& field, bool on_cells,
                                       std::span<const double> values,
                                       const Snapshot& snapshot) const {
  const std::size_t n = field.components.size();
  for (std::size_t c = 0; c < n; ++c)
    for (const Expr& reading : table_readings(field.components[c])) {
      const std::array outside{is_outside(reading)};
      auto found = on_cells ? cell_values(space_, outside, snapshot.values())
                            : nodal_values(space_, outside, snapshot.values());
      FieldSpec one = field;
      one.components = {field.components[c]};
      forget_where_absent(space_, one, on_cells, found);
      for (std::size_t k = 0; k < found.size(); ++k)
        if (found[k] > 0.0 && !std::isfinite(values[k * n + c]))
          refuse_reading(field.origin, fmt::format("the field `{}`", field.name), *reading.table(),
                         snapshot.t());
    }
}

void FieldGrids::add_state_array(StateField& one, const Snapshot& snapshot) {
  const FieldSpec& field = one.field();
  auto& data = grids_.front().grid.cell_data;
  data.push_back(
      vtk_array(field.name, static_cast<int>(field.components.size()), one.of_cells(snapshot)));
  data.back().unit = field.unit;
}

/// Where several points share a grid point (a corner with two normals) or a cell: their weighted
/// mean. Where there is none: the mean of those beside it.
void FieldGrids::fill_contact(OnContact& part, VtuGrid& grid, const Snapshot& snapshot) const {
  auto& sampler = part.sampler;
  const auto n = static_cast<std::size_t>(part.field.components.size());
  const auto size = static_cast<std::size_t>(sampler.size());
  const bool in_body = sampler.in_body();
  const std::size_t places =
      in_body ? grid.connectivity.size() / nodes_of(grid.cell) : grid.points.size();
  std::vector<double> at_points(n * size), weights(places, 0.0);
  sampler.evaluate(contact_, snapshot, at_points);
  std::vector<double> values(n * places, 0.0);
  for (std::size_t p = 0; p < size; ++p) {
    const double weight = sampler.points().weight[p];
    weights[part.grid_point[p]] += weight;
    for (std::size_t c = 0; c < n; ++c)
      values[part.grid_point[p] * n + c] += weight * at_points[c * size + p];
  }
  divide_by(weights, n, values);
  weights.assign(weights.size(), 0.0);
  for (const auto& [bare, known] : part.beside) {
    weights[static_cast<std::size_t>(bare)] += 1.0;
    for (std::size_t c = 0; c < n; ++c)
      values[static_cast<std::size_t>(bare) * n + c] +=
          values[static_cast<std::size_t>(known) * n + c];
  }
  divide_by(weights, n, values);
  auto& data = in_body ? grid.cell_data : grid.point_data;
  data.assign(1, vtk_array(part.field.name, static_cast<int>(n), values));
  data.back().unit = part.field.unit;
}

const std::vector<FieldGrid>& FieldGrids::fill(const Snapshot& snapshot) {
  for (FieldGrid& one : grids_) one.grid.time = snapshot.t();
  std::size_t next = 0;
  if (!body_.empty() || !of_states_.empty()) {
    VtuGrid& grid = grids_[next++].grid;
    grid.point_data.clear();
    grid.cell_data.clear();
    for (const auto& field : body_) add_body_array(field, snapshot);
    for (StateField& one : of_states_) add_state_array(one, snapshot);
  }
  for (auto& part : contact_parts_) fill_contact(part, grids_[next++].grid, snapshot);
  return grids_;
}

} // namespace hvi::solver
