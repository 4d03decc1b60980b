// See inertia.hpp. Called where operators are assembled, and by the energies.
#include "solver/discrete/inertia.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/discrete/contact_states.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/linear/dense.hpp"
#include "solver/plan/couplings.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

namespace hvi::solver {
namespace {

/// So many rings of neighbours are looked at for weights.
constexpr int most_rings = 4;
/// Of the Gram matrix of affine functions at the nodes around, the least eigenvalue by the largest.
constexpr double least_spread = 1e-4;

bool is_unilateral(const LawGraph& graph) {
  const auto infinite = [](double slope) { return std::abs(slope) >= unbounded_slope; };
  return std::ranges::any_of(graph.left, infinite) || std::ranges::any_of(graph.right, infinite);
}

/// By node of the space: does a law on this unknown with a unilateral part touch it?
std::vector<char> unilateral_nodes(const Problem& problem, const Discretisation& d, int unknown) {
  std::vector<char> out(d.space.nodes.size(), 0);
  for (std::size_t l = 0; l < problem.law_terms.size(); ++l) {
    const LawTerm& term = problem.law_terms[l];
    if (term.field != field_of_u(0) || term.unknown != unknown) continue;
    const Law law(problem.laws[static_cast<std::size_t>(term.law)]);
    const LawPoints points = assemble_law(d.space, d.parts[static_cast<std::size_t>(term.part)],
                                          term, static_cast<int>(l), law.spec().radial);
    const auto times = initial_law_times(problem, law, points, problem.time.grid.front());
    for (std::size_t p = 0; p < points.x.size(); ++p) {
      if (!is_unilateral(law.graph(points.x[p], times[p]))) continue;
      const auto first = static_cast<Eigen::Index>(p) * points.rows;
      for (Eigen::Index row = first; row < first + points.rows; ++row)
        for (SparseMatrix::InnerIterator it(points.g, row); it; ++it)
          if (it.value() != 0.0) out[static_cast<std::size_t>(it.col() / d.space.components)] = 1;
    }
  }
  return out;
}

struct Weighted {
  std::vector<std::int32_t> nodes;
  Vector weights;
};

/// The shortest w with sum_j w_j = 1 and sum_j w_j (x_j - x) = 0; nothing where the nodes lie too
/// flat.
std::optional<Vector> affine_weights(const Space& space, const Point& x,
                                     const std::vector<std::int32_t>& nodes) {
  const int dim = space.mesh->dim;
  double size = 0.0;
  for (const auto j : nodes)
    for (int a = 0; a < dim; ++a)
      size = std::max(size, std::abs(space.nodes[static_cast<std::size_t>(j)][a] - x[a]));
  DenseMatrix v(static_cast<Eigen::Index>(nodes.size()), dim + 1);
  for (Eigen::Index j = 0; j < v.rows(); ++j) {
    const Point& at = space.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(j)])];
    v(j, 0) = 1.0;
    for (int a = 0; a < dim; ++a) v(j, a + 1) = (at[a] - x[a]) / size;
  }
  if (v.rows() < v.cols()) return std::nullopt;
  const DenseMatrix gram = v.transpose() * v;
  const Vector spectrum = symmetric_eigenvalues(gram);
  if (!(spectrum[0] > least_spread * spectrum[dim])) return std::nullopt;
  return Vector(v * solve_positive(gram, Vector::Unit(dim + 1, 0)));
}

/// What stands for node c: weights on nodes that keep their mass and have functions of that order,
/// of as few rings as will do; none where there are not enough of them.
std::optional<Weighted> around(const Space& space, const std::vector<char>& massless, int order,
                               std::int32_t c) {
  const auto vertices = static_cast<std::int32_t>(space.mesh->nodes.size());
  const NodeGraph& graph = *space.graph;
  std::vector<std::int32_t> seen{c};
  Weighted out;
  for (int ring = 0; ring < most_rings; ++ring) {
    std::vector<std::int32_t> next = seen;
    for (const auto i : seen)
      next.insert(next.end(), graph.neighbours.begin() + graph.offsets[static_cast<std::size_t>(i)],
                  graph.neighbours.begin() + graph.offsets[static_cast<std::size_t>(i) + 1]);
    std::ranges::sort(next);
    next.erase(std::unique(next.begin(), next.end()), next.end());
    seen.swap(next);
    out.nodes.clear();
    for (const auto j : seen)
      if (massless[static_cast<std::size_t>(j)] == 0 && (order == space.order || j < vertices))
        out.nodes.push_back(j);
    if (auto weights = affine_weights(space, space.nodes[static_cast<std::size_t>(c)], out.nodes)) {
      out.weights = std::move(*weights);
      return out;
    }
  }
  return std::nullopt;
}

/// By dof itself, or the one that it is one with.
std::vector<std::int32_t> one_of(const Discretisation& d) {
  std::vector<std::int32_t> out(static_cast<std::size_t>(d.space.n_dofs()));
  std::iota(out.begin(), out.end(), 0);
  for (const DofLink& link : d.dofs.links) out[static_cast<std::size_t>(link.dof)] = link.to;
  return out;
}

/// Adds the rows of P on the dofs of one unknown. True: some node loses its mass.
bool extend(const Problem& problem, const Discretisation& d, int unknown,
            std::vector<Eigen::Triplet<double>>& entries) {
  const Space& space = d.space;
  const SpaceBlock& block = space.blocks[static_cast<std::size_t>(unknown)];
  std::vector<char> massless = has_inertia(problem, unknown)
                                   ? unilateral_nodes(problem, d, unknown)
                                   : std::vector<char>(space.nodes.size(), 0);
  const auto of_dof = one_of(d);
  for (const bool back : {false, true}) // nodes that repeat each other have no mass together
    for (const DofLink& link : d.dofs.links) {
      const auto from = static_cast<std::size_t>((back ? link.to : link.dof) / space.components);
      const auto to = static_cast<std::size_t>((back ? link.dof : link.to) / space.components);
      massless[to] = static_cast<char>(massless[to] | massless[from]);
    }
  const auto around_of = [&](std::int32_t node) {
    return massless[static_cast<std::size_t>(node)] != 0
               ? around(space, massless, block.order, node)
               : std::nullopt;
  };
  for (std::int32_t node = 0; node < std::ssize(space.nodes); ++node) {
    const auto own = around_of(node);
    for (int c = block.first; c < block.first + block.components; ++c) {
      const auto dof = static_cast<std::size_t>(space.dof(node, c));
      const std::int32_t first = of_dof[dof] / space.components;
      const auto others = first == node ? own : around_of(first);
      if (!others) {
        entries.emplace_back(space.dof(node, c), space.dof(node, c), 1.0);
        continue;
      }
      for (std::size_t j = 0; j < others->nodes.size(); ++j)
        entries.emplace_back(space.dof(node, c), space.dof(others->nodes[j], c),
                             others->weights[static_cast<Eigen::Index>(j)]);
    }
  }
  return std::ranges::find(massless, 1) != massless.end();
}

/// P on all dofs; a node without enough others around it keeps its mass. None: all do.
std::optional<SparseMatrix> extension(const Problem& problem, const Discretisation& d) {
  if (!takes_mass_off_contact(problem)) return std::nullopt;
  std::vector<Eigen::Triplet<double>> entries;
  bool any = false;
  for (int b = 0; b < n_unknowns(d.space); ++b) any = extend(problem, d, b, entries) || any;
  if (!any) return std::nullopt;
  SparseMatrix out(d.space.n_dofs(), d.space.n_dofs());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// By node: does P^T M P have other rows than M there? Dofs that are one are so together.
std::vector<char> nodes_of_moved_mass(const Discretisation& d, const SparseMatrix& p) {
  const Space& space = d.space;
  std::vector<char> out(space.nodes.size(), 0);
  for (int dof = 0; dof < p.rows(); ++dof) {
    const int first = p.outerIndexPtr()[dof], end = p.outerIndexPtr()[dof + 1];
    if (end == first + 1 && p.innerIndexPtr()[first] == dof) continue;
    const auto node = static_cast<std::size_t>(dof / space.components);
    out[node] = 1;
    for (auto k = space.graph->offsets[node]; k < space.graph->offsets[node + 1]; ++k)
      out[static_cast<std::size_t>(space.graph->neighbours[k])] = 1;
    for (int e = first; e < end; ++e)
      out[static_cast<std::size_t>(p.innerIndexPtr()[e] / space.components)] = 1;
  }
  for (const bool back : {false, true})
    for (const DofLink& link : d.dofs.links) {
      const auto from = static_cast<std::size_t>((back ? link.to : link.dof) / space.components);
      const auto to = static_cast<std::size_t>((back ? link.dof : link.to) / space.components);
      out[to] = static_cast<char>(out[to] | out[from]);
    }
  return out;
}

/// What of a part touches one of these nodes.
Region touching(const Space& space, const Region& part, const std::vector<char>& nodes) {
  Region out;
  out.kind = part.kind;
  const auto any = [&](std::span<const std::int32_t> of) {
    return std::ranges::any_of(of, [&](auto node) { return nodes[node] != 0; });
  };
  for (const auto entity : part.entities)
    if (part.kind == Group::Kind::cells    ? any(space.nodes_of_cell(entity))
        : part.kind == Group::Kind::facets ? any(space.nodes_of_facet(entity))
                                           : nodes[entity] != 0)
      out.entities.push_back(entity);
  return out;
}

/// P^T M P
SparseMatrix moved(const SparseMatrix& m, const SparseMatrix& p) {
  const SparseMatrix mp = m * p;
  return SparseMatrix(SparseMatrix(p.transpose()) * mp);
}

} // namespace

bool takes_mass_off_contact(const Problem& problem) {
  return problem.time.scheme == Scheme::midpoint && in_motion(problem) &&
         std::ranges::any_of(problem.law_terms, [&](const LawTerm& term) {
           return term.field == field_of_u(0) && has_inertia(problem, term.unknown);
         });
}

SparseMatrix inertia_matrix(const Problem& problem, const Discretisation& d) {
  SparseMatrix out = matrix_of_field(problem, d, field_of_u(2));
  const auto p = extension(problem, d);
  return p ? moved(out, *p) : out;
}

MovedMass moved_mass(const Problem& problem, const Discretisation& d, const StateLayout& layout) {
  MovedMass out{{}, SparseMatrix(layout.n_unknowns, layout.n_state)};
  const auto p = extension(problem, d);
  if (!p) return out;
  const auto nodes = nodes_of_moved_mass(d, *p);
  SparseMatrix m(d.space.n_dofs(), d.space.n_dofs());
  for (const FormTerm& form : problem.forms) {
    if (form.field != field_of_u(2)) continue;
    const Region around = touching(d.space, d.parts[static_cast<std::size_t>(form.part)], nodes);
    if (!around.entities.empty()) m = SparseMatrix(m + assemble_form(d.space, around, form));
  }
  out.matrix = restrict_rows(moved(m, *p), layout);
  const auto is_moved = [&](Eigen::Index row) {
    return nodes[static_cast<std::size_t>(layout.dof_of[row] / d.space.components)] != 0;
  };
  out.matrix.prune([&](Eigen::Index row, Eigen::Index, double) { return is_moved(row); });
  for (std::int32_t row = 0; row < layout.n_unknowns; ++row)
    if (is_moved(row)) out.rows.push_back(row);
  return out;
}

SparseMatrix load_transfer(const Problem& problem, const Discretisation& d) {
  auto p = extension(problem, d);
  if (!p) return {};
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < p->rows(); ++row) {
    const bool imposed = d.dofs.unknown_of[static_cast<std::size_t>(row)] < 0;
    if (imposed) entries.emplace_back(row, row, 1.0);
    for (SparseMatrix::InnerIterator it(*p, row); it && !imposed; ++it)
      entries.emplace_back(static_cast<int>(it.col()), row, it.value());
  }
  SparseMatrix out(p->rows(), p->cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

} // namespace hvi::solver
