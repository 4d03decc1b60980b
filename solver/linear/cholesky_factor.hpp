// K = L L^T by CHOLMOD with the contact unknowns last: the factor itself, without its solves.
#pragma once

#include "solver/linear/cholmod_session.hpp"
#include "solver/linear/factorisation.hpp"
#include "solver/linear/permuted_lower.hpp"

namespace hvi::solver {

/// A copy is another one for matrices of the same pattern, not factored yet.
class CholeskyFactor {
public:
  /// Analyses the pattern; what is known of the factor goes to `statistics`.
  CholeskyFactor(const SparseMatrix& k, std::span<const int> contact, OrderStore* known,
                 FactorStatistics& statistics);

  /// The values of L. `take_diagonal` has to be asked whether they are any good.
  void compute(const SparseMatrix& k);
  /// The inverse diagonal of L on the interior. Throws NotFactorable where a pivot is not finite or
  /// is nothing but rounding.
  void take_diagonal(std::vector<double>& inverse);
  /// L22, of the contact unknowns.
  void take_trailing_block(DenseMatrix& l22) const;

  const EliminationOrder& order() const { return order_; }
  const cholmod_factor& structure() const { return *factor_.l; }
  const double* values() const { return static_cast<const double*>(factor_.l->x); }
  double bytes() const; ///< with L22 and S

private:
  [[noreturn]] void fail_at(int position, double pivot) const;

  CholmodFactor factor_;
  PermutedLower a_;
  EliminationOrder order_;
};

} // namespace hvi::solver
