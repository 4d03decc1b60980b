// The range of a few rows.
#pragma once

#include "solver/linear/sparse.hpp"

namespace hvi::solver {

/// Orthonormal columns spanning the range of `rows`, then more of them up to rows.rows(). Gram and
/// Schmidt with the longest column first, so that equal rows give equal frames; `rank` is set.
DenseMatrix basis_of_range(const DenseMatrix& rows, int& rank);

} // namespace hvi::solver
