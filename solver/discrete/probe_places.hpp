// Where a report asks for values at points.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"

#include <vector>

namespace hvi::solver {

/// Failure(bad_value) for each probe at a point that is not in the part it names. Points outside
/// the mesh are not looked at.
std::vector<Failure> outside_parts(const Plan& plan, const Discretisation& discretisation);

/// A value of an unknown at a point where two sides meet that share no node there, pieces that
/// touch or the sides of a crack, so that it has several. What reads a multiplier or a state is
/// that of the law's side.
struct SeveralValues {
  const Probe* probe = nullptr;
  Point taken{}, other{}; ///< centres of cells: of the one that is read, and of one across
};
std::vector<SeveralValues> several_values(const ReportSpec& report,
                                          const Discretisation& discretisation);

} // namespace hvi::solver
