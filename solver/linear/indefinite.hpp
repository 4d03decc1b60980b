// Factors of symmetric matrices that are not definite: saddle points, heat beside displacements.
#pragma once

#include "solver/linear/factorisation.hpp"

#include <cstdint>

namespace hvi::solver {

/// d with d_i K_ij = d_j K_ji up to rounding, the same for all rows of one of several unknowns
/// (`of_unknown`, by row; empty: there is one); empty: there is none. Consolidation, and heat of
/// strain, are such: by backward Euler the rows of one unknown times -k are those of the columns.
Vector symmetrising_rows(const SparseMatrix& k, std::span<const std::uint8_t> of_unknown);

/// L D L^T by MUMPS, contact unknowns last, where rows of K need but factors to be symmetric; else,
/// and wherever that factor fails or is not accurate, general_factor (general_lu.hpp), which has
/// the last word. As analyse(), but the values of K choose the order, too.
std::unique_ptr<Factorisation> coupled_factor(const SparseMatrix& k, std::span<const int> contact,
                                              std::span<const std::uint8_t> of_unknown);

} // namespace hvi::solver
