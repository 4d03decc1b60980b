// The unsymmetric factorisation: UMFPACK on the interior, the Schur complement by n_c solves.
#pragma once

#include "solver/linear/factorisation.hpp"

namespace hvi::solver {

/// Analyses the pattern; `analyse` (factorisation.hpp) calls this for an unsymmetric matrix.
std::unique_ptr<Factorisation> analyse_lu(const SparseMatrix& k, std::span<const int> contact);

} // namespace hvi::solver
