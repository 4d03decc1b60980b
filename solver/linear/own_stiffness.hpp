// How stiff a body is at an unknown, of matrices that keep all unknowns.
#pragma once

#include "solver/linear/sparse.hpp"

namespace hvi::solver {

/// |K_ii|; where that is 0, as of the pressure of an incompressible body, what the elimination of
/// the others leaves of it at most:  sum_j |K_ij K_ji| / |K_jj|  over those with a diagonal.
Vector own_stiffness(const SparseMatrix& k);

} // namespace hvi::solver
