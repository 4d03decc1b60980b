// Expressions of fields at single points, as cell averages and at nodes: probes and output.
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/degree.hpp"
#include "solver/assembly/field_columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace hvi::solver {
namespace {

Region all_cells(const Mesh& mesh) {
  Region region;
  region.kind = Group::Kind::cells;
  region.entities.resize(mesh.cells.size());
  std::iota(region.entities.begin(), region.entities.end(), 0);
  return region;
}

/// Whether an expression jumps between cells: gradients and memberships in parts do.
bool is_cellwise(const Expr& e) {
  const auto slots = slots_of(e);
  return std::any_of(slots.begin(), slots.end(), [](Slot slot) {
    return slot::is_field_gradient(slot) ||
           (slot >= slot::first_inside && slot < slot::first_state);
  });
}

/// The nodes of the element as points with equal weights.
Quadrature element_nodes(int dim, int order) {
  Quadrature rule{dim, {}, {}};
  for (int k = 0; k <= dim; ++k) {
    Barycentric point{};
    point[k] = 1.0;
    rule.points.push_back(point);
  }
  for (int e = 0; order == 2 && e < static_cast<int>(simplex_edges(dim).size()); ++e) {
    Barycentric point{};
    for (const int end : simplex_edges(dim)[e]) {
      point[end] = 0.5;
    }
    rule.points.push_back(point);
  }
  rule.weights.assign(rule.points.size(), 1.0 / static_cast<double>(rule.points.size()));
  return rule;
}

} // namespace

namespace {

/// Where an unknown that the expressions read does not live; empty: nowhere.
std::vector<char> cells_outside(const Space& space, std::span<const Expr> expressions) {
  std::vector<char> out;
  for (const Expr& expression : expressions)
    for (const Slot s : slots_of(expression)) {
      if (!slot::is_field(s)) continue;
      const SpaceBlock& block =
          space.blocks[static_cast<std::size_t>(slot::unknown_of(slot::derivative_of(s)))];
      if (!block.domain) continue;
      out.resize(space.mesh->cells.size(), 0);
      for (std::size_t c = 0; c < out.size(); ++c)
        if (!block.lives_in(static_cast<int>(c))) out[c] = 1;
    }
  return out;
}

} // namespace

struct PointValue::Impl {
  FieldTape tape;
  PointBlock block;
  std::vector<double> out;
};

PointValue::PointValue(const Space& space, const Expr& expression, int cell,
                       const std::array<double, 4>& barycentric)
    : impl_(std::make_unique<Impl>(Impl{FieldTape(space, {&expression, 1}), {}, {}})) {
  PointBlock& block = impl_->block;
  const Point x = point_in_cell(*space.mesh, cell, barycentric);
  for (int j = 0; j < 3; ++j) {
    block.x[j].push_back(x[j]);
    block.normal[j].push_back(0.0);
  }
  block.weight.push_back(1.0);
  block.cell.push_back(cell);
  block.entity.push_back(cell);
  block.barycentric.push_back(barycentric);
  block.indicators = space.indicators;
}

PointValue::~PointValue() = default;
PointValue::PointValue(PointValue&&) noexcept = default;

double PointValue::operator()(const FieldValues& values) {
  impl_->tape.evaluate(impl_->block, values, impl_->out);
  return impl_->out.front();
}

double extreme_of(std::span<const double> values, Extreme which) {
  const double sign = which == Extreme::largest ? 1.0 : -1.0;
  double out = -std::numeric_limits<double>::infinity();
  for (const double value : values) {
    if (std::isnan(value)) return value;
    out = std::max(out, sign * value);
  }
  return sign * out;
}

double extreme_value(const Space& space, const Region& region, const Expr& expression,
                     const FieldValues& values, Extreme which) {
  FieldTape tape(space, {&expression, 1});
  const RegionPoints points(space, region,
                            element_nodes(dimension_of(*space.mesh, region), space.order));
  std::vector<double> out, of_blocks;
  points.for_blocks([&](const PointBlock& block) {
    tape.evaluate(block, values, out);
    of_blocks.push_back(extreme_of({out.data(), block.size()}, which));
  });
  return extreme_of(of_blocks, which);
}

std::vector<double> cell_values(const Space& space, std::span<const Expr> components,
                                const FieldValues& values) {
  int degree = 0;
  for (const Expr& e : components) {
    degree = std::max(degree, exact_degree(e, 0, space.order));
  }
  FieldTape tape(space, components);
  const RegionPoints points(space, all_cells(*space.mesh), Rule::exact, degree);
  const std::size_t n_components = components.size();
  std::vector<double> sums(space.mesh->cells.size() * n_components, 0.0), out;
  std::vector<double> measure(space.mesh->cells.size(), 0.0);
  points.for_blocks([&](const PointBlock& block) {
    tape.evaluate(block, values, out);
    for (std::size_t p = 0; p < block.size(); ++p) {
      const auto cell = static_cast<std::size_t>(block.cell[p]);
      measure[cell] += block.weight[p];
      for (std::size_t c = 0; c < n_components; ++c) {
        sums[cell * n_components + c] += block.weight[p] * out[c * block.size() + p];
      }
    }
  });
  const auto outside = cells_outside(space, components);
  for (std::size_t k = 0; k < sums.size(); ++k) {
    sums[k] /= measure[k / n_components];
    if (!outside.empty() && outside[k / n_components] != 0) sums[k] = 0.0;
  }
  return sums;
}

std::vector<double> nodal_values(const Space& space, std::span<const Expr> components,
                                 const FieldValues& values) {
  // Without gradients every cell gives the same value at a node, so one mean serves both: but a
  // mean of equal numbers is not those numbers to the last bit, hence the first cell's value there.
  const bool mean = std::any_of(components.begin(), components.end(), is_cellwise);
  FieldTape tape(space, components);
  const RegionPoints points(space, all_cells(*space.mesh),
                            element_nodes(space.mesh->dim, space.order));
  const std::size_t n_components = components.size();
  std::vector<double> sums(space.nodes.size() * n_components, 0.0), out;
  std::vector<double> measure(space.nodes.size(), 0.0);
  points.for_blocks([&](const PointBlock& block) {
    tape.evaluate(block, values, out);
    for (std::size_t p = 0; p < block.size(); ++p) {
      // Blocks begin with a whole cell.
      const auto node =
          static_cast<std::size_t>(space.nodes_of_cell(block.cell[p])[p % points.per_entity()]);
      if (!mean && measure[node] > 0.0) {
        continue;
      }
      const double weight = mean ? block.weight[p] : 1.0;
      measure[node] += weight;
      for (std::size_t c = 0; c < n_components; ++c) {
        sums[node * n_components + c] += weight * out[c * block.size() + p];
      }
    }
  });
  for (std::size_t k = 0; k < sums.size(); ++k) {
    // A node of no cell (a mesh file may have some) has no value.
    sums[k] = measure[k / n_components] > 0.0 ? sums[k] / measure[k / n_components] : 0.0;
  }
  return sums;
}

} // namespace hvi::solver
