// How a solution moves with its right-hand side (tangent.cpp).
#pragma once

#include "solver/inequality/last_factor.hpp"

#include <span>

namespace hvi::solver {

/// InequalitySolver::respond; `at` goes to the state.
bool respond(const InequalityState& state, std::span<const Vector> r, Position& at,
             const StiffnessPattern& pattern, LastFactor& factor, std::vector<Vector>& change_c,
             std::vector<Vector>& change_xi);

} // namespace hvi::solver
