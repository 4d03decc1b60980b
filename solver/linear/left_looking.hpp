// The numeric phase of the supernodal Cholesky factorisation.
#pragma once

#include "solver/linear/cholmod_session.hpp"
#include "solver/linear/permuted_lower.hpp"

namespace hvi::solver {

/// Fills `values`, doubles or floats, of the factor of `a`, which has the structure of `l`: the
/// first `interior` columns of it, and in the place of the others what is left of `a` there, their
/// Schur complement. Takes each supernode once, subtracts what the ones before it contribute and
/// factors its dense block: the operations of cholmod_l_super_numeric in their order: the same
/// factor to rounding. CHOLMOD's own makes a parallel region, with a system call at its end, for
/// every loop over a few rows, and reads the clock twice for every dense product: an eighth of its
/// time in 2D. Returns the column whose pivot is not positive, or `interior`: there is none.
template <class Entry>
Long factor_left_looking(const PermutedLower& a, const cholmod_factor& l, int interior,
                         Entry* values);

} // namespace hvi::solver
