// What the expressions of a report read.
#pragma once

#include "solver/plan/problem.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// Which fields a set of expressions reads (slot::field numbering).
std::vector<bool> fields_read(std::span<const Expr> expressions, int n_fields);
/// Or a state: what is known at the points of laws only.
bool reads_multiplier(const Expr& expression);
bool reads_gradient(const Expr& expression, int n_fields);

} // namespace hvi::solver
