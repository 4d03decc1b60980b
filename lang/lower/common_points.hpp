// Laws that know of each other act at the same points.
#pragma once

#include "solver/plan/problem.hpp"

namespace hvi::lang {

/// Where a law reads another one's multiplier, and where laws share states of their part (they read
/// them, or rates read their multipliers), all take the points of the highest order among their
/// unknowns. Laws that have nothing to do with each other keep the points of their own unknown.
void give_common_points(solver::Problem& problem);

} // namespace hvi::lang
