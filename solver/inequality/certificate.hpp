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
/// Multipliers whose forces are at most `part` of the largest terms of any equation become 0.
/// False: there were none. Whether their laws allow that says the certificate.
bool drop_rounding(Position& at, double part);

} // namespace hvi::solver
