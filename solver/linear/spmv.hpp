// Sparse products of the time loop, bound by memory: several matrices with one pattern are
// multiplied in one pass that reads the indices once, and a residual is measured as it is computed.
#pragma once

#include "solver/linear/sparse.hpp"

#include <span>

namespace hvi::solver {

/// The term factor * A x of a sum of products.
struct Product {
  const SparseMatrix* matrix;
  const Vector* vector;
  double factor = 1.0;
};

/// True if the two matrices are compressed and have the same rows, columns and entries' places.
bool same_pattern(const SparseMatrix& a, const SparseMatrix& b);

/// y = sum of the terms, whose matrices must have the same pattern (`same_pattern`: checked by the
/// caller once, not here). y is none of the factors. No allocation when y has its size.
void multiply(std::span<const Product> terms, Vector& y);

/// How well x solves K x = b, row by row: the certificate's number, with 0/0 = 0.
struct BackwardError {
  double error = 0.0; ///< max_i |b - K x|_i / (|K| |x| + |b|)_i; NaN if a row is not finite
  int row = -1;       ///< where; -1 if every row is exact
};

/// One pass over K. With `r`, also stores r = b - K x.
BackwardError backward_error(const SparseMatrix& k, const Vector& x, const Vector& b,
                             Vector* r = nullptr);

} // namespace hvi::solver
