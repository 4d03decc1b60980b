// The unsymmetric factorisation: UMFPACK's L U with diagonal pivots and the contact unknowns last.
#pragma once

#include "solver/linear/factorisation.hpp"

namespace hvi::solver {

/// Analyses the pattern; `analyse` (factorisation.hpp) calls this for an unsymmetric matrix. The
/// pattern must be symmetric, as that of a bilinear form is.
std::unique_ptr<Factorisation> analyse_lu(const SparseMatrix& k, std::span<const int> contact);

} // namespace hvi::solver
