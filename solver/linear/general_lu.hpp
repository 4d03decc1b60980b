// Factors of matrices whose diagonal gives no safe pivots: problems with several unknowns.
#pragma once

#include "solver/linear/factorisation.hpp"

namespace hvi::solver {

/// Of saddle points (a pressure has no stiffness of its own), unknowns of different units and
/// couplings that are not symmetric. As analyse(), but the values of K choose the order, too.
/// Throws NotFactorable where a row is empty.
std::unique_ptr<Factorisation> general_factor(const SparseMatrix& k, std::span<const int> contact);

} // namespace hvi::solver
