// Poles of loads in space: is <f, v> finite for every v of V?
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/problem.hpp"

#include <optional>
#include <string>

namespace hvi::solver {

/// |f| ~ d^-exponent, d the distance from a point, a line or a surface through `at`.
struct SpacePole {
  Point at{};
  std::optional<double> t{}; ///< where it moves: a time of the grid at which it is there
  double exponent = 0.0;
};

/// "it grows like d^-1 at the distance d from poles at (0.77, 0.5), t = 0.3"
std::string describe_pole(const SpacePole& pole, int dim);

/// A pole of a load too strong for <f, v> to be finite for all v of the space: of exponent c or
/// more on a set of codimension c in the load's part, of c/2 or more before a derivative of v.
/// Where v is held on a surface of poles, |v| <= d^(1/2) ||v||, and 3/2 is the bound (Hardy's
/// inequality). Found are zeros of denominators and of bases of negative powers that change their
/// sign in a cell or facet, or are 0 on a side of it, and those of sums of squares of affine
/// functions (norms), in loads of places and time that may read memberships in parts and normals,
/// too. Nothing is said that is not measured at such a place.
std::optional<SpacePole> space_pole(const Problem& problem, const Discretisation& d,
                                    const LoadTerm& load);

} // namespace hvi::solver
