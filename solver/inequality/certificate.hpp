// The certificate of a solve, from nothing but (c, xi), the laws and the operator.
#pragma once

#include "solver/inequality/position.hpp"

namespace hvi::solver {

/// inclusion = max_p dist(xi_p, dj_p(z_p)) / max(|xi|_inf, slope scale of p's law)
/// residual  = max_i |S c + G^T W xi - r|_i / (|S||c| + |G^T W||xi| + |r|)_i
/// of the place, and whether both are within the tolerance. `snap`: how close to a break counts as
/// on it.
void certify(Position& at, double tolerance, InequalityReport& report,
             double snap = Snap::certificate);
/// Forces of multipliers below this part of the tolerance, times the largest force on the same of
/// several unknowns, are rounding of the latter.
constexpr double rounding_of_tolerance = 1e-2;
/// Multipliers whose forces are at most `most` become 0. False: there were none. Whether laws and
/// equations allow that says a certificate.
bool drop_rounding(const ReducedProblem& problem, const ByUnknown& most, Vector& xi);

} // namespace hvi::solver
