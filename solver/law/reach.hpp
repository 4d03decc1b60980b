// Which cases of a law are ever taken.
#pragma once

#include "solver/kernel/expr.hpp"

#include <vector>

namespace hvi::solver {

/// The cases | conditions[0] -> ... | conditions[1] -> ... that no argument reaches, because the
/// ones before hold wherever they do. Only conditions on the argument alone are judged; none where
/// one depends on anything else, is constant (a parameter chooses), or turns too often.
std::vector<int> unreached_cases(const std::vector<Expr>& conditions, bool radial);

} // namespace hvi::solver
