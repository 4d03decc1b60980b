// How large the factor of a matrix would be, found without an ordering: bodies are cut in halves
// across their longest side until a dozen nodes are left, and each cut counts as the dense front
// that it is (A. George, Nested dissection of a regular finite element mesh, SIAM J. Numer. Anal.
// 10 (1973) 345-363). Thin plates and long bars are so told from cubes.
#pragma once

#include "solver/fem/space.hpp"

#include <span>

namespace hvi::solver {

struct FactorEstimate {
  double nonzeros = 0, flops = 0; ///< of L
};

/// How many unknowns each node has, and how many of those are eliminated last, as those of the
/// contact are.
FactorEstimate estimate_factor(std::span<const Point> nodes, const NodeGraph& graph,
                               std::span<const int> unknowns, std::span<const int> last);

} // namespace hvi::solver
