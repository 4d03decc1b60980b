// The bilinear forms of a plan as few matrices as possible; see operators.hpp.
#include "solver/discrete/operators.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/common/parallel.hpp"
#include "solver/discrete/body_states.hpp"
#include "solver/discrete/contact_states.hpp"
#include "solver/discrete/distinct_forms.hpp"
#include "solver/discrete/inertia.hpp"
#include "solver/discrete/shared_work.hpp"
#include "solver/linear/dense.hpp"
#include "solver/linear/mirror_pairs.hpp"
#include "solver/linear/same_pattern.hpp"
#include "solver/plan/couplings.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace hvi::solver {
namespace {

/// Terms in groups that are assembled in one pass: those on the same cells; each other one alone.
std::vector<std::vector<int>> in_passes(const Discretisation& discretisation,
                                        std::span<const FormTerm* const> terms) {
  std::vector<std::vector<int>> passes;
  for (int i = 0; i < static_cast<int>(terms.size()); ++i) {
    const auto same = std::find_if(passes.begin(), passes.end(), [&](const auto& pass) {
      const int part = terms[i]->part;
      return terms[pass.front()]->part == part &&
             discretisation.parts[part].kind == Group::Kind::cells;
    });
    if (same != passes.end())
      same->push_back(i);
    else
      passes.push_back({i});
  }
  return passes;
}

} // namespace

std::vector<SparseMatrix> assemble_terms(const Discretisation& discretisation,
                                         const StateLayout& layout,
                                         std::span<const FormTerm* const> terms, int threads) {
  std::vector<SparseMatrix> matrices(terms.size());
  // Rows of periodic parts are added up afterwards.
  const bool linked = !layout.links.empty();
  const DofSelection dofs =
      linked ? DofSelection{} : DofSelection{layout.entry_of, layout.n_unknowns, layout.n_state};
  // What runs have in common is taken and put there one by one.
  if (discretisation.shared || threads > 1) {
    const int at_once = discretisation.shared ? 1 : threads;
    for_each_piece(static_cast<int>(terms.size()), at_once, [&](int i) {
      const auto assemble = [&] {
        SparseMatrix whole = assemble_form(discretisation.space,
                                           discretisation.parts[terms[i]->part], *terms[i], dofs);
        return linked ? restrict_rows(whole, layout) : whole;
      };
      SparseMatrix made =
          discretisation.shared ? discretisation.shared->form(*terms[i], assemble) : assemble();
      matrices[i].swap(made); // Eigen 3.4 copies what is moved
    });
    return matrices;
  }
  for (const auto& pass : in_passes(discretisation, terms)) {
    std::vector<const FormTerm*> chosen;
    for (const int i : pass) chosen.push_back(terms[i]);
    auto made = assemble_forms(discretisation.space, discretisation.parts[chosen.front()->part],
                               chosen, dofs);
    for (std::size_t k = 0; k < pass.size(); ++k) {
      if (linked) made[k] = restrict_rows(made[k], layout);
      matrices[pass[k]].swap(made[k]);
    }
  }
  return matrices;
}

namespace {

/// Appends the forms that read states, each kind with a base matrix of its own.
void add_changing(const Problem& problem, const Discretisation& discretisation,
                  const StateLayout& layout, int threads, Operators& operators) {
  const auto distinct = distinct_terms(problem, operators.n_fields(),
                                       [](const FormTerm& term) { return reads_states(term); });
  if (distinct.terms.empty()) return;
  check_initial_states(problem, discretisation);
  std::vector<FormTerm> initial(distinct.terms.size());
  std::vector<const FormTerm*> terms(distinct.terms.size());
  for (std::size_t i = 0; i < terms.size(); ++i) {
    initial[i] = at_initial_states(problem, *distinct.terms[i]);
    terms[i] = &initial[i];
  }
  auto matrices = assemble_terms(discretisation, layout, terms, threads);
  const auto before = operators.weights.cols();
  operators.weights.conservativeResize(Eigen::NoChange,
                                       before + static_cast<Eigen::Index>(terms.size()));
  for (std::size_t i = 0; i < terms.size(); ++i) {
    operators.weights.col(before + static_cast<Eigen::Index>(i)) = distinct.weights[i];
    operators.changing.emplace_back(operators.n_bases(), distinct.terms[i]);
    operators.bases.push_back(std::move(matrices[i]));
    const bool mirrored = stays_mirrored(*distinct.terms[i]);
    const bool symmetric = has_symmetric_tensor(problem, *distinct.terms[i]);
    operators.symmetric = operators.symmetric && (mirrored || symmetric);
    operators.mirrored = operators.mirrored && mirrored;
  }
  operators.shared = nullptr; // these factors are of one moment
}

} // namespace

void take_apart(const Couplings& couplings, const Space& space, const StateLayout& layout,
                std::vector<SparseMatrix>& matrices) {
  if (!space.is_product()) return;
  std::vector<std::size_t> of;
  for (const auto dof : layout.dof_of)
    of.push_back(static_cast<std::size_t>(space.block_of(dof % space.components)));
  for (SparseMatrix& matrix : matrices) {
    matrix.prune([&](Eigen::Index i, Eigen::Index j, double) {
      const std::size_t a = of[static_cast<std::size_t>(i)], b = of[static_cast<std::size_t>(j)];
      return a == b || couplings[a][b] || couplings[b][a];
    });
    matrix.makeCompressed();
  }
}

bool symmetric_to_rounding(const SparseMatrix& matrix) {
  const double largest =
      Eigen::Map<const Vector>(matrix.valuePtr(), matrix.nonZeros()).lpNorm<Eigen::Infinity>();
  return all_mirror_pairs(matrix, [&](int, int, double left, double right) {
    return std::abs(left - right) <= asymmetry_of_rounding * largest;
  });
}

SparseMatrix matrix_of_field(const Problem& problem, const Discretisation& discretisation,
                             int field) {
  const int n = discretisation.space.n_dofs();
  SparseMatrix out(n, n);
  for (const auto& form : problem.forms) {
    if (form.field != field) continue;
    SparseMatrix one = assemble_form(discretisation.space, discretisation.parts[form.part],
                                     reads_states(form) ? at_initial_states(problem, form) : form);
    if (out.nonZeros() == 0)
      out.swap(one);
    else
      out = SparseMatrix(out + one);
  }
  return out;
}

Operators assemble_operators(const Problem& problem, const Discretisation& discretisation,
                             const StateLayout& layout, int threads, bool by_values) {
  if (problem.forms.empty())
    throw Failure(FailureKind::bad_value, problem.space.origin,
                  "nothing resists: the plan has no form");
  const int n_fields = count_fields(problem);
  const bool plain_inertia = !takes_mass_off_contact(problem);
  auto distinct = distinct_terms(problem, n_fields, [&](const FormTerm& term) {
    return (plain_inertia || term.field != field_of_u(2)) && !reads_states(term);
  });
  auto matrices = assemble_terms(discretisation, layout, distinct.terms, threads);
  if (!plain_inertia) {
    matrices.push_back(restrict_rows(inertia_matrix(problem, discretisation), layout));
    distinct.weights.push_back(Vector::Unit(n_fields, field_of_u(2)));
  }
  const Couplings couplings = couplings_of(problem);
  take_apart(couplings, discretisation.space, layout, matrices);
  if (by_values) merge_equal_values(matrices, distinct.weights);
  merge_equal_weights(matrices, distinct.weights);

  Operators out;
  out.shared = discretisation.shared.get();
  out.n_unknowns = layout.n_unknowns;
  out.mirrored = // sums of rows and columns are made in an order of their own
      layout.links.empty() && std::ranges::all_of(distinct.terms, [&](const FormTerm* term) {
        return is_mirrored(problem, *term);
      });
  const bool symmetric =
      plain_inertia && std::ranges::all_of(distinct.terms, [&](const FormTerm* term) {
        return has_symmetric_tensor(problem, *term) || is_mirrored(problem, *term);
      });
  out.weights.resize(n_fields, static_cast<Eigen::Index>(matrices.size()));
  for (std::size_t b = 0; b < matrices.size(); ++b) {
    out.weights.col(static_cast<Eigen::Index>(b)) = distinct.weights[b];
    out.symmetric =
        out.symmetric && (symmetric || out.mirrored || symmetric_to_rounding(matrices[b]));
  }
  out.coupled = couples_unknowns(couplings);
  out.symmetric = out.symmetric && !out.coupled;
  out.bases = std::move(matrices);
  add_changing(problem, discretisation, layout, threads, out);
  return out;
}

SparseMatrix on_unknowns(const SparseMatrix& base, int n_unknowns) {
  return base.cols() == n_unknowns ? base : SparseMatrix(base.leftCols(n_unknowns));
}

namespace {

SparseMatrix combine_halves(std::span<const SymmetricBlocks> halves, const Vector& gamma) {
  if (const auto sum = SymmetricBlocks::sum(halves, gamma); !sum.empty()) return sum.by_rows();
  SparseMatrix sum = gamma[0] * halves[0].by_rows();
  for (std::size_t b = 1; b < halves.size(); ++b)
    sum = SparseMatrix(sum + gamma[static_cast<Eigen::Index>(b)] * halves[b].by_rows());
  return sum;
}

} // namespace

SparseMatrix combine(const Operators& operators, const Vector& gamma) {
  if (!operators.halves.empty()) return combine_halves(operators.halves, gamma);
  SparseMatrix sum = on_unknowns(operators.bases[0], operators.n_unknowns);
  sum.coeffs() *= gamma[0];
  // Eigen keeps the union of the patterns, entries times zero included: one analysis serves all.
  for (int b = 1; b < operators.n_bases(); ++b) {
    const SparseMatrix& base = operators.bases[b];
    const bool whole = base.cols() == operators.n_unknowns;
    const SparseMatrix cut = whole ? SparseMatrix() : on_unknowns(base, operators.n_unknowns);
    const SparseMatrix& part = whole ? base : cut;
    if (same_pattern(sum, part))
      sum.coeffs() += gamma[b] * part.coeffs();
    else
      sum = SparseMatrix(sum + gamma[b] * part);
  }
  return sum;
}

} // namespace hvi::solver
