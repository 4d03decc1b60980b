// A kernel of memory as a problem states it.
#pragma once

#include "solver/common/failure.hpp"
#include "solver/kernel/expr.hpp"
#include "solver/kernel/prony_series.hpp"

#include <optional>
#include <string>

namespace hvi::solver {

/// A scalar kernel as data: an expression in slot::lag and slot::t (q(t, s) = expression(t, t -
/// s)).
struct KernelSpec {
  std::string name;
  Origin origin;
  Expr expression;
  std::optional<PronySeries> series{}; ///< where the expression was written as one
};

/// How a memory is evaluated; solver/history.
enum class HistoryRoute { automatic, recursion, fit, tree, direct };

} // namespace hvi::solver
