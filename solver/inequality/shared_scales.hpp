// What a solve and its certificate have to agree on.
#pragma once

namespace hvi::solver {

/// Displacements are known up to rounding of the largest one: this part of it counts in the scale
/// of each.
constexpr double part_of_largest_reach = 0.01;

/// In the scale of a row of the equation, of what its terms are with turned axes: the rounding that
/// it covers stays far below any tolerance.
constexpr double part_of_turned_row = 0.01;

} // namespace hvi::solver
