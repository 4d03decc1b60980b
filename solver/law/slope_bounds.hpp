// Between which numbers the slope of a law stays, and what it tends to.
#pragma once

#include "solver/law/law.hpp"

namespace hvi::solver {

/// Of the slope j' at one point of space and time; infinite where it is beyond unbounded_slope. For
/// a radial law r >= 0, and `at_minus` says nothing.
struct SlopeBounds {
  double low = 0.0, high = 0.0;         ///< all values lie between
  double at_minus = 0.0, at_plus = 0.0; ///< the limits for r -> -inf and r -> inf
};

/// Exact for polynomial pieces and for others that rise or fall all along; where one does neither,
/// its extremes are sampled, and widened by a tenth. Far out, a slope that still grows by a half
/// from 1e6 to 1e12 of the law's own scale counts as infinite.
SlopeBounds slope_bounds(const Law& law, const LawGraph& graph);

} // namespace hvi::solver
