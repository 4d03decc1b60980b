// Expressions at many points.
#include "solver/fem/pointwise.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {
namespace {

/// Enough to amortise the tape's loop over instructions, few enough for its registers to stay in
/// the cache.
constexpr std::size_t block_points = 512;

/// For each of the nodes a cell that has it as a vertex.
std::vector<std::int32_t> cells_of_nodes(const Mesh& mesh, std::span<const std::int32_t> nodes) {
  std::vector<std::int32_t> cell_of(mesh.nodes.size(), -1);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    for (int k = 0; k <= mesh.dim; ++k) {
      cell_of[mesh.cells[c][k]] = static_cast<std::int32_t>(c);
    }
  }
  std::vector<std::int32_t> cells;
  for (const auto node : nodes) {
    cells.push_back(cell_of[node]);
  }
  return cells;
}

int vertex_in_cell(const Mesh& mesh, int cell, int node) {
  const auto& corners = mesh.cells[cell];
  return static_cast<int>(std::find(corners.begin(), corners.end(), node) - corners.begin());
}

} // namespace

void PointBlock::clear() {
  for (int j = 0; j < 3; ++j) {
    x[j].clear();
    normal[j].clear();
  }
  weight.clear();
  cell.clear();
  entity.clear();
  barycentric.clear();
  gap.clear();
  pair_point.clear();
  jump.reset();
}

int dimension_of(const Mesh& mesh, const Region& region) {
  switch (region.kind) {
  case Group::Kind::cells:
    return mesh.dim;
  case Group::Kind::facets:
    return mesh.dim - 1;
  case Group::Kind::points:
    return 0;
  }
  return 0;
}

namespace {

/// The rule of a plan; on axisymmetric meshes of a higher degree.
Quadrature rule_on(const Space& space, const Region& region, Rule rule, int exact_degree,
                   int order) {
  const int dim = dimension_of(*space.mesh, region);
  if (!space.mesh->axisymmetric) {
    return make_rule(rule, dim, order, exact_degree);
  }
  if (rule == Rule::gauss) {
    return simplex_rule(dim, 2 * order + 1);
  }
  return make_rule(rule, dim, order, exact_degree + (has_hoop(space) ? 3 : 1));
}

} // namespace

RegionPoints::RegionPoints(const Space& space, const Region& region, Rule rule, int exact_degree,
                           int order)
    : RegionPoints(space, region,
                   rule_on(space, region, rule, exact_degree, order > 0 ? order : space.order)) {
  if (order > 0) order_ = order;
  if (mesh_->axisymmetric) {
    const bool by_node = rule == Rule::nodal && kind_ != Group::Kind::points;
    ring_ = by_node ? Ring::by_node : Ring::by_point;
  }
}

RegionPoints::RegionPoints(const Space& space, const Region& region, Quadrature rule)
    : mesh_(space.mesh), indicators_(space.indicators), kind_(region.kind),
      entities_(region.entities), rule_(std::move(rule)), order_(space.order) {
  if (kind_ == Group::Kind::cells) {
    cells_ = entities_;
  } else if (kind_ == Group::Kind::points) {
    cells_ = cells_of_nodes(*mesh_, entities_);
  } else {
    for (const auto facet : entities_) {
      cells_.push_back(mesh_->facets[facet].cell);
    }
  }
}

RegionPoints::Simplex RegionPoints::simplex(std::size_t e) const {
  const int entity = entities_[e], dim = mesh_->dim;
  Simplex out;
  if (kind_ == Group::Kind::facets) {
    out.measure = facet_measure(*mesh_, entity);
    out.normal = facet_normal(*mesh_, entity);
    const auto local = facet_in_cell(*mesh_, entity);
    std::copy(local.begin(), local.end(), out.corners.begin());
    out.n_corners = dim;
  } else if (kind_ == Group::Kind::cells) {
    out.measure = cell_measure(*mesh_, entity);
    out.n_corners = dim + 1;
  } else {
    out.corners[0] = vertex_in_cell(*mesh_, cells_[e], entity);
  }
  return out;
}

void RegionPoints::weigh(std::size_t e, const Simplex& entity, std::vector<double>& out) const {
  if (ring_ == Ring::none) {
    out = rule_.weights;
    return;
  }
  std::array<double, 4> x{};
  for (int k = 0; k < entity.n_corners; ++k) {
    x[k] = mesh_->nodes[mesh_->cells[cells_[e]][entity.corners[k]]][0];
  }
  if (kind_ == Group::Kind::points) {
    out.assign(1, x[0] > 0.0 ? circumference(*mesh_, x[0]) : 1.0);
  } else if (ring_ == Ring::by_node) {
    out = weighted_nodal_rule(entity.n_corners - 1, order_,
                              {x.data(), static_cast<std::size_t>(entity.n_corners)});
    for (double& weight : out) {
      weight = circumference(*mesh_, weight);
    }
  } else {
    out = rule_.weights;
    for (std::size_t q = 0; q < out.size(); ++q) {
      double at = 0.0;
      for (int k = 0; k < entity.n_corners; ++k) {
        at += rule_.points[q][k] * x[k];
      }
      out[q] *= circumference(*mesh_, at);
    }
  }
}

void RegionPoints::fill(std::size_t first, std::size_t last, PointBlock& block) const {
  block.clear();
  block.kind = kind_;
  block.indicators = indicators_;
  std::vector<double> weights;
  for (std::size_t e = first; e < last; ++e) {
    const Simplex entity = simplex(e);
    weigh(e, entity, weights);
    for (std::size_t q = 0; q < rule_.size(); ++q) {
      Barycentric local{};
      for (int k = 0; k < entity.n_corners; ++k) {
        local[entity.corners[k]] = rule_.points[q][k];
      }
      const Point x = point_in_cell(*mesh_, cells_[e], local);
      for (int j = 0; j < 3; ++j) {
        block.x[j].push_back(x[j]);
        block.normal[j].push_back(entity.normal[j]);
      }
      block.weight.push_back(entity.measure * weights[q]);
      block.cell.push_back(cells_[e]);
      block.entity.push_back(entities_[e]);
      block.barycentric.push_back(local);
    }
  }
}

void RegionPoints::for_blocks(const std::function<void(const PointBlock&)>& f) const {
  const std::size_t step = std::max<std::size_t>(1, block_points / per_entity());
  PointBlock block;
  for (std::size_t first = 0; first < entities(); first += step) {
    fill(first, std::min(entities(), first + step), block);
    f(block);
  }
}

Pointwise::Pointwise(std::span<const Expr> expressions) : tape_(compile(expressions)) {}

void Pointwise::evaluate(std::size_t n, const Columns& columns, Origin origin,
                         std::span<double> out) {
  pointers_.clear();
  for (const Slot slot : tape_.inputs) {
    pointers_.push_back(columns(slot));
    if (!pointers_.back()) {
      throw Failure(FailureKind::bad_value, origin,
                    fmt::format("{} has no value here", describe_slot(slot)));
    }
  }
  hvi::solver::evaluate(tape_, pointers_, n, out, workspace_);
}

void Pointwise::evaluate(const PointBlock& block, double t, Origin origin, std::span<double> out,
                         const Columns& more) {
  const auto columns = [&](Slot slot) -> const double* {
    if (slot == slot::t) {
      time_.assign(block.size(), t);
      return time_.data();
    }
    for (int j = 0; j < 3; ++j) {
      if (slot == slot::x(j)) {
        return block.x[j].data();
      }
      if (slot == slot::normal(j)) {
        return block.normal[j].data();
      }
    }
    if (slot == slot::gap && !block.gap.empty()) return block.gap.data();
    if (slot >= slot::first_inside && slot < slot::first_state && block.indicators) {
      return inside_column(block, slot);
    }
    return more ? more(slot) : nullptr;
  };
  evaluate(block.size(), columns, origin, out);
}

const double* Pointwise::inside_column(const PointBlock& block, Slot slot) {
  const int part = slot - slot::first_inside;
  if (part >= static_cast<int>(block.indicators->parts.size())) {
    return nullptr;
  }
  auto& column = inside_[slot];
  column.resize(block.size());
  for (std::size_t p = 0; p < block.size(); ++p) {
    column[p] = block.indicators->value(part, block.kind, block.entity[p], block.cell[p]);
  }
  return column.data();
}

std::string describe_slot(Slot slot) {
  if (slot < 3) {
    return fmt::format("the coordinate {}", "xyz"[slot]);
  }
  if (slot == slot::t) {
    return "the time t";
  }
  if (slot == slot::lag) {
    return "the lag t - s";
  }
  if (slot == slot::gap) return "the gap of a pair";
  if (slot >= slot::normal(0) && slot <= slot::normal(2)) {
    return "the normal";
  }
  if (slot >= slot::argument(0) && slot <= slot::argument(2)) {
    return "the argument of a law";
  }
  if (slot >= slot::first_probe) {
    return "another probe";
  }
  if (slot::is_state(slot)) {
    return "a state";
  }
  if (slot >= slot::first_inside) {
    return "membership in a part";
  }
  if (slot >= slot::first_multiplier) {
    return "a multiplier";
  }
  if (slot < slot::first_field) {
    return "the test function";
  }
  const int field = slot::field_of(slot);
  const std::string name = field == field_of_u(0)   ? "u"
                           : field == field_of_u(1) ? "u'"
                           : field == field_of_u(2)
                               ? "u''"
                               : fmt::format("history field {}", memory_of(field));
  return slot::is_field_gradient(slot) ? "the gradient of " + name : name;
}

void throw_not_finite(Origin origin, const std::string& what, double value, const Point& point,
                      int dim, const double* t) {
  const double shown = std::isnan(value) ? std::abs(value) : value; // its sign says nothing
  std::string message = fmt::format("{} is {} at {}", what, shown, describe_point(point, dim));
  if (t) {
    message += fmt::format(", t = {:.6g}", *t);
  }
  throw Failure(FailureKind::bad_value, origin, message);
}

} // namespace hvi::solver
