// Bilinear forms: K_ij = int sum_e C_e D_{trial_e}(phi_j) D_{test_e}(phi_i).
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/element_matrix.hpp"
#include "solver/assembly/pattern.hpp"
#include "solver/fem/pointwise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace hvi::solver {
namespace {

/// A form with constant coefficients on cells, in a pass that several of them share.
struct ConstantForm {
  FormEntries entries;
  ElementKernel kernel;
  double* values; ///< of its matrix
  Rule rule;
};

bool same(const CellGeometry& a, const CellGeometry& b) {
  return a.measure == b.measure && a.gradient == b.gradient;
}

/// The last few shapes of cells that differ, and what all forms make of each of them: in a
/// structured mesh the others are moved copies, often to the last bit.
class ShapeMemory {
public:
  ShapeMemory(const Space& space, std::size_t forms) : space_(space), forms_(forms) {}
  /// The matrices of a cell of this shape; null: it is new, and they are to be made in `next`.
  const std::vector<ElementMatrix>* find(const CellGeometry& geometry) const {
    for (std::size_t k = 0; k < known_; ++k)
      if (same(shapes_[k], geometry)) return &elements_[k];
    return nullptr;
  }
  std::vector<ElementMatrix>& next(const CellGeometry& geometry) {
    shapes_[next_] = geometry;
    auto& elements = elements_[next_];
    if (elements.empty())
      elements = blank();
    else
      for (auto& element : elements) element.clear();
    next_ = (next_ + 1) % most;
    known_ = std::min(known_ + 1, most);
    return elements;
  }

private:
  static constexpr std::size_t most = 6; // the simplices of a cube

  std::vector<ElementMatrix> blank() const {
    std::vector<ElementMatrix> out(forms_);
    for (auto& element : out) {
      element.components = space_.components;
      element.local.resize(space_.nodes_per_cell);
      std::iota(element.local.begin(), element.local.end(), 0);
      element.nodes.resize(space_.nodes_per_cell);
      element.clear();
    }
    return out;
  }

  const Space& space_;
  std::size_t forms_;
  std::array<CellGeometry, most> shapes_;
  std::array<std::vector<ElementMatrix>, most> elements_;
  std::size_t known_ = 0, next_ = 0;
};

/// No points, no tape. All forms have the same quadrature.
void assemble_constant(const Space& space, const Region& region, std::span<ConstantForm> forms,
                       const MatrixPattern& pattern) {
  bool gradients = false;
  for (ConstantForm& form : forms) {
    std::vector<double> coefficients;
    for (const Expr& c : form.entries.coefficients) coefficients.push_back(c.value());
    form.entries.set(coefficients.data(), 1);
    gradients = gradients || form.entries.gradients;
  }
  const Quadrature quadrature =
      make_rule(forms.front().rule, space.mesh->dim, space.order, forms.front().entries.degree);
  ShapeMemory memory(space, forms.size());
  ShapeTable shapes;
  std::vector<int> edges;
  for (const auto cell : region.entities) {
    const CellGeometry geometry = cell_geometry(*space.mesh, cell);
    const auto* elements = memory.find(geometry);
    if (elements == nullptr) {
      auto& made = memory.next(geometry);
      for (std::size_t q = 0; q < quadrature.size(); ++q) {
        evaluate_shapes(space, geometry, quadrature.points[q], gradients, shapes);
        for (std::size_t f = 0; f < forms.size(); ++f)
          forms[f].kernel(made[f], forms[f].entries, shapes,
                          geometry.measure * quadrature.weights[q]);
      }
      elements = &made;
    }
    const auto nodes = space.nodes_of_cell(cell);
    pattern.locate(nodes, edges);
    for (std::size_t f = 0; f < forms.size(); ++f)
      pattern.add(nodes, edges, (*elements)[f].data.data(), forms[f].values);
  }
}

/// Those with the quadrature of the first share its pass; then those of the first that is left ...
void assemble_constants(const Space& space, const Region& region, std::vector<ConstantForm> forms,
                        const MatrixPattern& pattern) {
  while (!forms.empty()) {
    const Rule rule = forms.front().rule;
    const int degree = forms.front().entries.degree;
    const auto rest = std::stable_partition(forms.begin(), forms.end(), [&](const auto& form) {
      return form.rule == rule && form.entries.degree == degree;
    });
    assemble_constant(space, region, {forms.begin(), rest}, pattern);
    forms.erase(forms.begin(), rest);
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
  void run(const MatrixPattern& pattern, double* values) {
    points_.for_blocks([&](const PointBlock& block) { add_block(block, pattern, values); });
  }

private:
  void add_block(const PointBlock& block, const MatrixPattern& pattern, double* values) {
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
      pattern.locate(element_.nodes, edges_);
      pattern.add(element_.nodes, edges_, element_.data.data(), values);
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
  std::vector<int> edges_;
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

std::vector<SparseMatrix> assemble_forms(const Space& space, const Region& region,
                                         std::span<const FormTerm* const> terms,
                                         const DofSelection& dofs) {
  const bool on_cells = region.kind == Group::Kind::cells;
  std::vector<FormEntries> entries;
  bool gradients = false;
  for (const FormTerm* term : terms) {
    entries.push_back(sort_entries(space, *term));
    gradients = gradients || entries.back().gradients;
    if (region.kind == Group::Kind::points && gradients)
      throw Failure(FailureKind::bad_value, term->origin,
                    "a gradient has no value at a single point; use values of u and v there");
  }
  NodeGraph own_graph;
  if (!on_cells) own_graph = graph_of(space, region, gradients);
  MatrixPattern pattern(on_cells ? *space.graph : own_graph, space.components, dofs);
  std::vector<SparseMatrix> matrices(terms.size());
  for (std::size_t f = 0; f + 1 < terms.size(); ++f) matrices[f] = pattern.zeros();
  pattern.hand_over(matrices.back());
  std::vector<ConstantForm> constant;
  for (std::size_t f = 0; f < terms.size(); ++f) {
    double* const values = matrices[f].valuePtr();
    // The weight of an axisymmetric mesh varies in a cell: through the points.
    if (on_cells && entries[f].constant && !space.mesh->axisymmetric)
      constant.push_back({std::move(entries[f]), nullptr, values, terms[f]->rule});
    else if (!entries[f].coefficients.empty())
      VariableAssembler(space, region, *terms[f], entries[f]).run(pattern, values);
  }
  for (auto& form : constant) form.kernel = whole_cell_kernel(space, form.entries);
  assemble_constants(space, region, std::move(constant), pattern);
  return matrices;
}

SparseMatrix assemble_form(const Space& space, const Region& region, const FormTerm& term,
                           const DofSelection& dofs) {
  const FormTerm* const terms[] = {&term};
  SparseMatrix matrix;
  matrix.swap(assemble_forms(space, region, terms, dofs).front()); // Eigen 3.4 copies what is moved
  return matrix;
}

int degree_of(const Space& space, const FormTerm& term) { return sort_entries(space, term).degree; }

} // namespace hvi::solver
