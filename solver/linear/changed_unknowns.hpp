// A direct solver of K u = b that eliminates other unknowns: with u = T x it factors T^T K T.
#pragma once

#include "solver/linear/basis_change.hpp"
#include "solver/linear/factorisation.hpp"

namespace hvi::solver {

/// `of_changed` was analysed for T^T K T, with contact unknowns among the x. The result is a
/// factorisation of K: its order takes b to T^T b and x to u, and S is that of the x.
std::unique_ptr<Factorisation> with_changed_unknowns(std::unique_ptr<Factorisation> of_changed,
                                                     std::shared_ptr<const BasisChange> change);

/// What eliminates: `of` itself, or the solver behind it.
const Factorisation& eliminating(const Factorisation& of);

} // namespace hvi::solver
