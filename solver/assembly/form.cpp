// Bilinear forms: K_ij = int sum_e C_e D_{trial_e}(phi_j) D_{test_e}(phi_i).
//
// At a quadrature point the entries between component c of the test function and component d of the
// trial function form a small matrix T over the rows of a ShapeTable S (value, d/dx_0, ...); the
// element matrix of that pair is  sum_q w_q S^T T S.
#include "solver/assembly/assembly.hpp"
#include "solver/assembly/degree.hpp"
#include "solver/assembly/pattern.hpp"
#include "solver/fem/pointwise.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int max_element = 3 * max_cell_nodes;

/// Where one entry stands in the matrix T of its pair of components.
struct Place {
  int block, row, column;
};
struct Block {
  int test_component, trial_component;
  std::array<std::array<double, 4>, 4> t{};
};

/// The entries of a form, sorted into blocks.
struct Entries {
  std::vector<Place> places;
  std::vector<Block> blocks;
  std::vector<Expr> coefficients;
  bool constant = true, gradients = false, values = false;
  int degree = 0; ///< for the rule `exact`
};

int block_of(std::vector<Block>& blocks, int test, int trial) {
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (blocks[b].test_component == test && blocks[b].trial_component == trial) {
      return static_cast<int>(b);
    }
  }
  blocks.push_back({test, trial, {}});
  return static_cast<int>(blocks.size()) - 1;
}

Entries sort_entries(const Space& space, const FormTerm& term) {
  Entries out;
  for (const auto& entry : term.entries) {
    if (entry.coefficient.is(0.0)) {
      continue;
    }
    const Derivative test = decode(space, entry.test, term.origin);
    const Derivative trial = decode(space, entry.trial, term.origin);
    out.places.push_back(
        {block_of(out.blocks, test.component, trial.component), test.row, trial.row});
    out.coefficients.push_back(entry.coefficient);
    out.constant = out.constant && entry.coefficient.is_constant();
    out.gradients = out.gradients || test.row > 0 || trial.row > 0;
    out.values = out.values || test.row == 0 || trial.row == 0;
    const int shapes =
        shape_degree(entry.test, space.order) + shape_degree(entry.trial, space.order);
    out.degree = std::max(out.degree, exact_degree(entry.coefficient, shapes, space.order));
  }
  return out;
}

/// Sets T of every block from the coefficients (stride apart) at one point.
void set_blocks(Entries& entries, const double* coefficients, std::size_t stride) {
  for (auto& block : entries.blocks) {
    block.t = {};
  }
  for (std::size_t e = 0; e < entries.places.size(); ++e) {
    const Place& place = entries.places[e];
    entries.blocks[place.block].t[place.row][place.column] += coefficients[e * stride];
  }
}

/// An element matrix under construction. `local` lists the shape functions that take part.
struct Element {
  std::vector<std::int32_t> nodes;
  std::vector<int> local;
  int components = 1;
  std::array<double, max_element * max_element> matrix{};
  void clear() {
    const std::size_t width = nodes.size() * components;
    std::fill_n(matrix.begin(), width * width, 0.0);
  }
};

/// matrix += weight S^T T S for all blocks. Rows [first, past) of S; n = 0: size known at run time
/// only. The sizes of P1 as template arguments make the loops unroll.
template <int first, int past, int n>
void accumulate(Element& element, const Entries& entries, const ShapeTable& s, double weight,
                int run_past) {
  const int size = n > 0 ? n : static_cast<int>(element.local.size());
  const int end = past > 0 ? past : run_past;
  const int m = element.components, width = size * m;
  double picked[4][max_cell_nodes], ts[4][max_cell_nodes];
  for (int r = first; r < end; ++r) {
    for (int i = 0; i < size; ++i) {
      picked[r][i] = s.row(r)[n > 0 ? i : element.local[i]];
    }
  }
  for (const Block& block : entries.blocks) {
    for (int r = first; r < end; ++r) {
      for (int j = 0; j < size; ++j) {
        double sum = 0.0;
        for (int k = first; k < end; ++k) {
          sum += block.t[r][k] * picked[k][j];
        }
        ts[r][j] = weight * sum;
      }
    }
    for (int i = 0; i < size; ++i) {
      double* row = element.matrix.data() + (i * m + block.test_component) * width;
      for (int j = 0; j < size; ++j) {
        double sum = 0.0;
        for (int r = first; r < end; ++r) {
          sum += picked[r][i] * ts[r][j];
        }
        row[j * m + block.trial_component] += sum;
      }
    }
  }
}

void accumulate_general(Element& element, const Entries& entries, const ShapeTable& shapes,
                        double weight) {
  accumulate<0, 0, 0>(element, entries, shapes, weight, shapes.rows);
}

/// Constant coefficients on cells: no points, no tape.
void assemble_constant(const Space& space, const Region& region, Rule rule, Entries& entries,
                       ElementScatter& scatter) {
  std::vector<double> coefficients;
  for (const Expr& c : entries.coefficients) {
    coefficients.push_back(c.value());
  }
  set_blocks(entries, coefficients.data(), 1);
  const int dim = space.mesh->dim;
  const Quadrature quadrature = make_rule(rule, dim, space.order, entries.degree);
  const bool p1_gradients = space.order == 1 && !entries.values;
  Element element;
  element.components = space.components;
  for (int i = 0; i < space.nodes_per_cell; ++i) {
    element.local.push_back(i);
  }
  ShapeTable shapes;
  for (const auto cell : region.entities) {
    const auto nodes = space.nodes_of_cell(cell);
    element.nodes.assign(nodes.begin(), nodes.end());
    element.clear();
    const CellGeometry geometry = cell_geometry(*space.mesh, cell);
    if (p1_gradients) {
      for (int j = 0; j < dim; ++j) {
        for (int k = 0; k <= dim; ++k) {
          shapes.row(1 + j)[k] = geometry.gradient[k][j];
        }
      }
      if (dim == 2) {
        accumulate<1, 3, 3>(element, entries, shapes, geometry.measure, 0);
      } else if (dim == 3) {
        accumulate<1, 4, 4>(element, entries, shapes, geometry.measure, 0);
      } else {
        accumulate<1, 2, 2>(element, entries, shapes, geometry.measure, 0);
      }
    } else {
      for (std::size_t q = 0; q < quadrature.size(); ++q) {
        evaluate_shapes(space, geometry, quadrature.points[q], entries.gradients, shapes);
        accumulate_general(element, entries, shapes, geometry.measure * quadrature.weights[q]);
      }
    }
    scatter.add(element.nodes, element.matrix.data());
  }
}

/// The nodes an entity couples: all of its cell's when gradients take part, else its own.
void pick_nodes(const Space& space, Group::Kind kind, int entity, int cell, bool gradients,
                Element& element) {
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
                    Entries& entries)
      : space_(space), kind_(region.kind), term_(term), entries_(entries),
        points_(space, region, term.rule, entries.degree), tape_(entries.coefficients) {
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
        set_blocks(entries_, values_.data() + q, n);
        accumulate_general(element_, entries_, shapes_, block.weight[q]);
      }
      scatter.add(element_.nodes, element_.matrix.data());
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
  Entries& entries_;
  RegionPoints points_;
  Pointwise tape_;
  Element element_;
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

void check_constants(const Entries& entries, Origin origin) {
  for (const Expr& c : entries.coefficients) {
    if (c.is_constant() && !std::isfinite(c.value())) {
      throw Failure(FailureKind::bad_value, origin, "a coefficient of the form is not finite");
    }
  }
}

} // namespace

SparseMatrix zero_matrix(const Space& space) {
  return make_pattern(*space.graph, space.components);
}

SparseMatrix assemble_form(const Space& space, const Region& region, const FormTerm& term) {
  Entries entries = sort_entries(space, term);
  check_constants(entries, term.origin);
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
