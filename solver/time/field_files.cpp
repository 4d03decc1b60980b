// The VTU and PVD files of one `fields` item; see field_files.hpp.
#include "solver/time/field_files.hpp"

#include "solver/fem/element.hpp"
#include "solver/time/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>

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

std::string safe_name(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
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

FieldFiles::FieldFiles(const Problem& problem, const Discretisation& d, const Contact& contact,
                       const FieldsSpec& spec, std::filesystem::path folder, std::string stem,
                       Durability durability)
    : space_(d.space), contact_(contact), n_fields_(count_fields(problem)),
      folder_(std::move(folder)), stem_(std::move(stem)), durability_(durability) {
  for (const auto& field : spec.fields) {
    if (std::none_of(field.components.begin(), field.components.end(), reads_multiplier)) {
      body_.push_back(field);
      continue;
    }
    LawSampler sampler(problem, d, contact, field.components, field.origin);
    const Region& region = d.parts[static_cast<std::size_t>(sampler.part())];
    OnContact part{field, std::move(sampler), {}, {}};
    const auto& nodes = part.sampler.nodes();
    std::vector<std::int64_t> point_of_node;
    if (part.sampler.in_body()) {
      part.grid = entity_grid(d.space, region, point_of_node);
      for (const auto cell : part.sampler.points().cell)
        part.grid_point.push_back(std::ranges::lower_bound(region.entities, cell) -
                                  region.entities.begin());
    } else if (std::all_of(nodes.begin(), nodes.end(), [](auto node) { return node >= 0; })) {
      part.grid = entity_grid(d.space, region, point_of_node);
      for (const auto node : nodes) part.grid_point.push_back(point_of_node[node]);
    } else {
      part.grid = point_grid(part.sampler.points());
      for (std::int64_t p = 0; p < part.sampler.size(); ++p) part.grid_point.push_back(p);
    }
    contact_parts_.push_back(std::move(part));
  }
  if (!body_.empty()) grid_ = body_grid(space_);
}

std::vector<Expr> FieldFiles::expressions() const {
  std::vector<Expr> out;
  for (const auto& field : body_)
    out.insert(out.end(), field.components.begin(), field.components.end());
  for (const auto& part : contact_parts_)
    out.insert(out.end(), part.field.components.begin(), part.field.components.end());
  return out;
}

void FieldFiles::add_body_array(const FieldSpec& field, const Snapshot& snapshot) {
  const auto n = static_cast<int>(field.components.size());
  const bool on_cells = std::any_of(field.components.begin(), field.components.end(),
                                    [&](const Expr& e) { return reads_gradient(e, n_fields_); });
  const auto values = on_cells ? cell_values(space_, field.components, snapshot.values())
                               : nodal_values(space_, field.components, snapshot.values());
  (on_cells ? grid_.cell_data : grid_.point_data).push_back(vtk_array(field.name, n, values));
}

/// Where several points share a grid point (a corner with two normals) or a cell: their weighted
/// mean.
void FieldFiles::fill_contact(OnContact& part, const Snapshot& snapshot) const {
  auto sampler = part.sampler;
  const auto n = static_cast<std::size_t>(part.field.components.size());
  const auto size = static_cast<std::size_t>(sampler.size());
  const bool in_body = sampler.in_body();
  const std::size_t places =
      in_body ? part.grid.connectivity.size() / nodes_of(part.grid.cell) : part.grid.points.size();
  std::vector<double> at_points(n * size), weights(places, 0.0);
  sampler.evaluate(contact_, snapshot, at_points);
  std::vector<double> values(n * places, 0.0);
  for (std::size_t p = 0; p < size; ++p) {
    const double weight = sampler.points().weight[p];
    weights[part.grid_point[p]] += weight;
    for (std::size_t c = 0; c < n; ++c)
      values[part.grid_point[p] * n + c] += weight * at_points[c * size + p];
  }
  for (std::size_t g = 0; g < weights.size(); ++g)
    for (std::size_t c = 0; c < n; ++c)
      if (weights[g] > 0) values[g * n + c] /= weights[g];
  auto& data = in_body ? part.grid.cell_data : part.grid.point_data;
  data.assign(1, vtk_array(part.field.name, static_cast<int>(n), values));
}

void FieldFiles::write_vtu(const VtuGrid& grid, int part, const std::string& name, double t,
                           std::vector<std::string>& written) {
  const std::string bytes = vtu_bytes(grid);
  write_atomically(folder_ / name, bytes, durability_);
  const auto inside = std::filesystem::path(name).filename().string();
  entries_.push_back({t, part, inside}); // the collection stands beside its files
  hashes_.push_back(hash_of(bytes));
  written.push_back(name);
}

void FieldFiles::write(const Snapshot& snapshot, std::vector<std::string>& written) {
  if (!body_.empty()) {
    grid_.point_data.clear();
    grid_.cell_data.clear();
    grid_.time = snapshot.t();
    for (const auto& field : body_) add_body_array(field, snapshot);
    write_vtu(grid_, 0, fmt::format("{}_{:05}.vtu", stem_, snapshot.step()), snapshot.t(), written);
  }
  int number = 0;
  for (auto& part : contact_parts_) {
    part.grid.time = snapshot.t();
    fill_contact(part, snapshot);
    write_vtu(part.grid, ++number,
              fmt::format("{}_{}_{:05}.vtu", stem_, safe_name(part.field.name), snapshot.step()),
              snapshot.t(), written);
  }
  write_atomically(folder_ / (stem_ + ".pvd"), pvd_bytes(entries_));
}

void FieldFiles::write_collection() const {
  if (resumed_ && !entries_.empty())
    write_atomically(folder_ / (stem_ + ".pvd"), pvd_bytes(entries_));
}

} // namespace hvi::solver
