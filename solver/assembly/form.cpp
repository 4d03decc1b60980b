// Bilinear forms: K_ij = int sum_e C_e D_{trial_e}(phi_j) D_{test_e}(phi_i).
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/element_matrix.hpp"
#include "solver/assembly/pattern.hpp"
#include "solver/fem/pointwise.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hvi::solver {
namespace {

/// Constant coefficients on cells: no points, no tape.
void assemble_constant(const Space& space, const Region& region, Rule rule, FormEntries& entries,
                       ElementScatter& scatter) {
  std::vector<double> coefficients;
  for (const Expr& c : entries.coefficients) {
    coefficients.push_back(c.value());
  }
  entries.set(coefficients.data(), 1);
  const Quadrature quadrature = make_rule(rule, space.mesh->dim, space.order, entries.degree);
  const ElementKernel kernel = whole_cell_kernel(space, entries);
  ElementMatrix element;
  element.components = space.components;
  element.local.resize(space.nodes_per_cell);
  std::iota(element.local.begin(), element.local.end(), 0);
  ShapeTable shapes;
  for (const auto cell : region.entities) {
    const auto nodes = space.nodes_of_cell(cell);
    element.nodes.assign(nodes.begin(), nodes.end());
    element.clear();
    const CellGeometry geometry = cell_geometry(*space.mesh, cell);
    for (std::size_t q = 0; q < quadrature.size(); ++q) {
      evaluate_shapes(space, geometry, quadrature.points[q], entries.gradients, shapes);
      kernel(element, entries, shapes, geometry.measure * quadrature.weights[q]);
    }
    scatter.add(element.nodes, element.data.data());
  }
}

/// The nodes an entity couples: all of its cell's when gradients take part, else its own.
void pick_nodes(const Space& space, Group::Kind kind, int entity, int cell, bool gradients,
                ElementMatrix& element) {
  const auto of_cell = space.nodes_of_cell(cell);
  if (kind == Group::Kind::cells || gradients) {
    element.nodes.assign(of_cell.begin(), of_cell.end());
  } else if (kind == Group::Kind::facets) {
    const auto of_facet = space.nodes_of_facet(entity);
    element.nodes.assign(of_facet.begin(), of_facet.end());
  } else {
    element.nodes.assign(1, entity);
  }
  element.local.clear();
  for (const auto node : element.nodes) {
    const auto place = std::find(of_cell.begin(), of_cell.end(), node);
    element.local.push_back(static_cast<int>(place - of_cell.begin()));
  }
}

/// Entities other than cells, and coefficients that vary: through the tape, block by block.
class VariableAssembler {
public:
  VariableAssembler(const Space& space, const Region& region, const FormTerm& term,
                    FormEntries& entries)
      : space_(space), kind_(region.kind), term_(term), entries_(entries),
        points_(space, region, term.rule, entries.degree), tape_(entries.coefficients),
        kernel_(region.kind == Group::Kind::cells ? whole_cell_kernel(space, entries)
                                                  : general_kernel) {
    element_.components = space.components;
  }
  void run(ElementScatter& scatter) {
    points_.for_blocks([&](const PointBlock& block) { add_block(block, scatter); });
  }

private:
  void add_block(const PointBlock& block, ElementScatter& scatter) {
    const std::size_t n = block.size(), step = points_.per_entity();
    values_.resize(n * entries_.coefficients.size());
    tape_.evaluate(block, 0.0, term_.origin, values_);
    check(block);
    for (std::size_t p = 0; p < n; p += step) {
      const int cell = block.cell[p];
      const CellGeometry geometry = cell_geometry(*space_.mesh, cell);
      pick_nodes(space_, kind_, block.entity[p], cell, entries_.gradients, element_);
      element_.clear();
      for (std::size_t q = p; q < p + step; ++q) {
        evaluate_shapes(space_, geometry, block.barycentric[q], entries_.gradients, shapes_);
        entries_.set(values_.data() + q, n);
        kernel_(element_, entries_, shapes_, block.weight[q]);
      }
      scatter.add(element_.nodes, element_.data.data());
    }
  }
  void check(const PointBlock& block) const {
    for (std::size_t k = 0; k < values_.size(); ++k) {
      if (std::isfinite(values_[k])) {
        continue;
      }
      throw_not_finite(term_.origin, "a coefficient of the form", values_[k],
                       block.point(k % block.size()), space_.mesh->dim);
    }
  }

  const Space& space_;
  Group::Kind kind_;
  const FormTerm& term_;
  FormEntries& entries_;
  RegionPoints points_;
  Pointwise tape_;
  ElementKernel kernel_;
  ElementMatrix element_;
  ShapeTable shapes_;
  std::vector<double> values_;
};

/// The node graph of a form that lives on facets or points: only the rows it touches.
NodeGraph graph_of(const Space& space, const Region& region, bool gradients) {
  std::vector<std::int32_t> nodes;
  int per_entity = 1;
  if (region.kind == Group::Kind::points) {
    nodes = region.entities;
  } else {
    per_entity = gradients ? space.nodes_per_cell : space.nodes_per_facet;
    for (const auto facet : region.entities) {
      const auto of_entity = gradients ? space.nodes_of_cell(space.mesh->facets[facet].cell)
                                       : space.nodes_of_facet(facet);
      nodes.insert(nodes.end(), of_entity.begin(), of_entity.end());
    }
  }
  return make_node_graph(space.nodes.size(), nodes, per_entity);
}

} // namespace

SparseMatrix zero_matrix(const Space& space) {
  return make_pattern(*space.graph, space.components);
}

SparseMatrix assemble_form(const Space& space, const Region& region, const FormTerm& term) {
  FormEntries entries = sort_entries(space, term);
  const bool on_cells = region.kind == Group::Kind::cells;
  if (region.kind == Group::Kind::points && entries.gradients) {
    throw Failure(FailureKind::bad_value, term.origin,
                  "a gradient has no value at a single point; use values of u and v there");
  }
  NodeGraph own_graph;
  if (!on_cells) {
    own_graph = graph_of(space, region, entries.gradients);
  }
  const NodeGraph& graph = on_cells ? *space.graph : own_graph;
  SparseMatrix matrix = make_pattern(graph, space.components);
  ElementScatter scatter(graph, space.components, matrix);
  if (on_cells && entries.constant) {
    assemble_constant(space, region, term.rule, entries, scatter);
  } else if (!entries.coefficients.empty()) {
    VariableAssembler(space, region, term, entries).run(scatter);
  }
  return matrix;
}

} // namespace hvi::solver
