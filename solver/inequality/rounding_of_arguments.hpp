// What a solve and its certificate have to agree on.
#pragma once

namespace hvi::solver {

/// Displacements are known up to rounding of the largest one: this part of it counts in the scale
/// of each.
constexpr double part_of_largest_reach = 0.01;

} // namespace hvi::solver
