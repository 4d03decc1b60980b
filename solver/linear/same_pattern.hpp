// Matrices whose entries stand at the same places.
#pragma once

#include "solver/linear/sparse.hpp"

namespace hvi::solver {

/// True if the two matrices are compressed and have the same rows, columns and entries' places.
bool same_pattern(const SparseMatrix& a, const SparseMatrix& b);

} // namespace hvi::solver
