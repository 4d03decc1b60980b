// The symmetric factorisation: CHOLMOD's supernodal L L^T with the contact unknowns last.
#pragma once

#include "solver/linear/factorisation.hpp"
#include "solver/linear/supernodes.hpp"

namespace hvi::solver {

/// Analyses the pattern; `analyse` (factorisation.hpp) calls this for a symmetric matrix.
std::unique_ptr<Factorisation> analyse_cholesky(const SparseMatrix& k, std::span<const int> contact,
                                                FactorEntries entries, OrderStore* known);

/// The factor itself, valid until the next factorisation; null before one, for one of singles, and
/// for a factorisation of another kind.
const LowerFactor* lower_factor(const Factorisation& of);

} // namespace hvi::solver
