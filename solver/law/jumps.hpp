// By how much an expression jumps where one of its comparisons turns: for laws, and for what they
// and states read (solver/hypotheses).
#pragma once

#include "solver/law/switches.hpp"

namespace hvi::solver {

/// Does the value of the switch's node jump where its function vanishes? (min, max, abs do not.)
bool may_jump(const Switch& s);

/// e just above the zero of the switch's function less e just below it, as an expression that holds
/// at the zero. Sums, products and cases are taken apart, so that what is equal on both sides
/// cancels.
Expr jump_across(const Expr& e, const Expr& node);

} // namespace hvi::solver
