// Which forms of a plan have a matrix of their own, and what is known of it before it is assembled.
#pragma once

#include "solver/linear/sparse.hpp"
#include "solver/plan/problem.hpp"

#include <functional>
#include <vector>

namespace hvi::solver {

/// Distinct matrices and, per field, their coefficients.
struct DistinctTerms {
  std::vector<const FormTerm*> terms;
  std::vector<Vector> weights; ///< per distinct term, one entry per field
};

/// Of the forms that `chosen` chooses.
DistinctTerms distinct_terms(const Problem& problem, int n_fields,
                             const std::function<bool(const FormTerm&)>& chosen);

/// Constant coefficients C that stay when test and trial function change places: whatever the mesh,
/// the matrix is symmetric.
bool is_mirrored(const Problem& problem, const FormTerm& term);
/// The same of coefficients that change.
bool stays_mirrored(const FormTerm& term);
/// Was it written with a tensor whose kind is symmetric?
bool has_symmetric_tensor(const Problem& problem, const FormTerm& term);

/// A matrix that is a multiple of an earlier one hands its weights over and goes.
void merge_equal_values(std::vector<SparseMatrix>& matrices, std::vector<Vector>& weights);
/// T_i and T_j that enter every field in one ratio become T_i + ratio T_j.
void merge_equal_weights(std::vector<SparseMatrix>& matrices, std::vector<Vector>& weights);

} // namespace hvi::solver
