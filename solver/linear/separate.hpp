// The factor of a matrix whose contact unknowns are coupled with no other.
#pragma once

#include "solver/linear/factorisation.hpp"

namespace hvi::solver {

/// For K = diag(S, D) with a dense symmetric S on the contact unknowns, which come first, and a
/// diagonal D: S is the Schur complement itself, and triangular solves only copy. `factor` throws
/// Failure(not_coercive) where K is not positive definite, Failure(bad_value) where it is no such
/// K.
std::unique_ptr<Factorisation> separate_factor(int n_contact, int size);

} // namespace hvi::solver
