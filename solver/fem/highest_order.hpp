// Whose points are nobody's own: those of states in a body, of integrals over a pair.
#pragma once

#include "solver/fem/space.hpp"

#include <algorithm>

namespace hvi::solver {

/// The first of the unknowns with the highest order.
inline int unknown_of_highest_order(const Space& space) {
  const auto highest = std::ranges::max_element(space.blocks, {}, &SpaceBlock::order);
  return static_cast<int>(highest - space.blocks.begin());
}

} // namespace hvi::solver
