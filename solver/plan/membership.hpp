// What an expression is away from a part.
#pragma once

#include "solver/kernel/expr.hpp"

#include <array>
#include <utility>

namespace hvi::solver {

/// An expression where its point is outside part `part` of the plan: what stands behind the
/// membership in it is gone.
inline Expr away_from(const Expr& e, int part) {
  return substitute(e, std::array{std::pair{slot::inside(part), Expr(0.0)}});
}

} // namespace hvi::solver
