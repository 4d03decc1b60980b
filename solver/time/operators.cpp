// The bilinear forms of a plan as few matrices as possible; see operators.hpp.
#include "solver/time/operators.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/common/parallel.hpp"
#include "solver/linear/mirror_pairs.hpp"
#include "solver/linear/spmv.hpp"
#include "solver/time/proportional.hpp"
#include "solver/time/shared_work.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

/// Distinct matrices and, per field, their coefficients.
struct Distinct {
  std::vector<const FormTerm*> terms;
  std::vector<Vector> weights; ///< per distinct term, one entry per field
};

Distinct distinct_terms(const Plan& plan, int n_fields) {
  Distinct out;
  for (const auto& term : plan.forms) {
    std::size_t known = 0;
    double ratio = 1.0;
    for (; known < out.terms.size(); ++known)
      if (const auto r = symbolic_ratio(term, *out.terms[known])) {
        ratio = *r;
        break;
      }
    if (known == out.terms.size()) {
      out.terms.push_back(&term);
      out.weights.push_back(Vector::Zero(n_fields));
    }
    out.weights[known][term.field] += ratio;
  }
  return out;
}

/// A matrix that is a multiple of an earlier one hands its weights over and goes.
void merge_equal_values(std::vector<SparseMatrix>& matrices, std::vector<Vector>& weights) {
  for (std::size_t j = 1; j < matrices.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      const auto ratio = numeric_ratio(matrices[j], matrices[i]);
      if (!ratio) continue;
      weights[i] += *ratio * weights[j];
      matrices.erase(matrices.begin() + j);
      weights.erase(weights.begin() + j);
      --j;
      break;
    }
}

/// T_i and T_j that enter every field in one ratio become T_i + ratio T_j.
void merge_equal_weights(std::vector<SparseMatrix>& matrices, std::vector<Vector>& weights) {
  for (std::size_t j = 1; j < matrices.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      const auto ratio = column_ratio(weights[j], weights[i]);
      if (!ratio) continue;
      matrices[i] = SparseMatrix(matrices[i] + *ratio * matrices[j]);
      matrices.erase(matrices.begin() + j);
      weights.erase(weights.begin() + j);
      --j;
      break;
    }
}

/// Symmetric on the unknowns to rounding of the assembly.
bool is_symmetric(const SparseMatrix& matrix) {
  const double largest =
      Eigen::Map<const Vector>(matrix.valuePtr(), matrix.nonZeros()).lpNorm<Eigen::Infinity>();
  return all_mirror_pairs(matrix, [&](int, int, double left, double right) {
    return std::abs(left - right) <= 1e-12 * largest;
  });
}

} // namespace

Operators assemble_operators(const Plan& plan, const Discretisation& discretisation,
                             const StateLayout& layout) {
  const int n_fields = first_history_field + static_cast<int>(plan.histories.size());
  auto distinct = distinct_terms(plan, n_fields);
  const int n_terms = static_cast<int>(distinct.terms.size());
  std::vector<SparseMatrix> matrices(distinct.terms.size());
  // What runs have in common is taken and put there one by one.
  const int threads = discretisation.shared ? 1 : plan.options.threads;
  for_each_piece(n_terms, threads, [&](int i) {
    const FormTerm& term = *distinct.terms[i];
    const auto assemble = [&] {
      return restrict_rows(
          assemble_form(discretisation.space, discretisation.parts[term.part], term), layout);
    };
    matrices[i] = discretisation.shared ? discretisation.shared->form(term, assemble) : assemble();
  });
  merge_equal_values(matrices, distinct.weights);
  merge_equal_weights(matrices, distinct.weights);

  Operators out;
  out.shared = discretisation.shared.get();
  out.n_unknowns = layout.n_unknowns;
  out.weights.resize(n_fields, static_cast<Eigen::Index>(matrices.size()));
  for (std::size_t b = 0; b < matrices.size(); ++b) {
    out.weights.col(static_cast<Eigen::Index>(b)) = distinct.weights[b];
    out.symmetric = out.symmetric && is_symmetric(matrices[b]);
  }
  out.bases = std::move(matrices);
  return out;
}

SparseMatrix on_unknowns(const SparseMatrix& base, int n_unknowns) {
  return base.cols() == n_unknowns ? base : SparseMatrix(base.leftCols(n_unknowns));
}

SparseMatrix combine(const Operators& operators, const Vector& gamma) {
  SparseMatrix sum = on_unknowns(operators.bases[0], operators.n_unknowns);
  sum.coeffs() *= gamma[0];
  // Eigen keeps the union of the patterns, entries times zero included: one analysis serves all.
  for (int b = 1; b < operators.n_bases(); ++b) {
    const SparseMatrix part = on_unknowns(operators.bases[b], operators.n_unknowns);
    if (same_pattern(sum, part))
      sum.coeffs() += gamma[b] * part.coeffs();
    else
      sum = SparseMatrix(sum + gamma[b] * part);
  }
  return sum;
}

} // namespace hvi::solver
