// LU of a sparse matrix with pivots by size, by UMFPACK: for matrices of contact unknowns and of
// states, which have no part to condense (factorisation.hpp is for those of bodies).
#pragma once

#include "solver/linear/sparse.hpp"
#include "solver/linear/umfpack_objects.hpp"

#include <memory>
#include <vector>

namespace hvi::solver {

class SparseLu {
public:
  /// False: the matrix is singular, or not finite. A pattern that was there before is not analysed
  /// again.
  bool factor(const SparseMatrix& a);
  /// a^-1 b, after a factor.
  Vector solve(const Vector& b) const;
  SparseMatrix solve(const SparseMatrix& b) const;
  int determinant_sign() const; ///< 0: there is no factor

private:
  std::vector<SuiteSparse_long> start_, column_; ///< the rows of a
  std::vector<double> value_;
  std::unique_ptr<void, FreeSymbolic> symbolic_;
  std::unique_ptr<void, FreeNumeric> numeric_;
};

} // namespace hvi::solver
