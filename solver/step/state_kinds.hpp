// States of several names side by side in one vector: entries of one state have one unit.
#pragma once

#include "solver/discrete/contact.hpp"

#include <vector>

namespace hvi::solver {

/// Of each entry of contact.state_values: which state it is of.
std::vector<int> kinds_of_states(const Contact& contact);

/// v_i / max_j v_j^2, j over the entries of the kind of i, so that its product with v has no unit
/// and each kind counts alike.
Vector by_squared_sizes(const Vector& v, const std::vector<int>& kinds);

} // namespace hvi::solver
