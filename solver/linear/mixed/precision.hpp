// The precision in which a triangular solve reads the factor.
#pragma once

namespace hvi::solver {

/// A solve takes the time of reading the factor: `single` reads 32 bits of an entry instead of 64,
/// `fine` 48. The arithmetic is double and S stays exact, but L_II and L_cI are rounded to 24 or 40
/// bits, so that a solve has a relative error of about 1e-7 or 2e-12 times the growth of the
/// matrix. Reduced precision pays where only a small correction is solved for and the true residual
/// is known: with a guess x* (the last increments, extrapolated) and b* = b - K x*,
///     forward(b*) -> r*,  r = r* + S c*,  the reduced problem gives c,  back(c - c*) -> x - x*.
enum class FactorPrecision { full, fine, single };

} // namespace hvi::solver
