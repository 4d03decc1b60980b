// Which of several unknowns act on which, as the forms and laws are stated.
#pragma once

#include "solver/kernel/slot.hpp"
#include "solver/plan/problem.hpp"

#include <array>
#include <vector>

namespace hvi::solver {

/// Which unknowns (columns) stand with the test functions of which (rows) in a form.
using Couplings = std::array<std::array<bool, slot::most_unknowns>, slot::most_unknowns>;
Couplings couplings_of(const Problem& problem);

/// Does a form have one unknown in it and the test function of another?
bool couples_unknowns(const Couplings& couplings);

/// By unknown: do laws act on it?
std::vector<char> unknowns_with_laws(const Problem& problem);

/// By unknown: has it neither forms nor laws of its own? A pressure, whose diagonal is 0.
std::vector<char> multipliers_of(const Problem& problem);

/// By unknown: the highest derivative in time of it that a form has. 0: its equation holds at every
/// time by itself (a potential).
std::vector<int> orders_in_time(const Problem& problem);

/// Has a form u'' of this unknown?
bool has_inertia(const Problem& problem, int unknown);

} // namespace hvi::solver
