// Expressions as bytes, for another process of the same program.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/kernel/expr.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// Node by node, shared ones once: exact bits, and as many nodes as there are here.
void put_expressions(StateWriter& w, std::span<const Expr> expressions);
std::vector<Expr> get_expressions(StateReader& r);

} // namespace hvi::solver
