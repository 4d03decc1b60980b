// A law that cannot be used, with the place in it.
#pragma once

#include "solver/kernel/expr.hpp"
#include "solver/law/law.hpp"

#include <optional>

namespace hvi::solver {

/// Failure(bad_law) that knows more than the law's name.
struct LawFailure : Failure {
  LawFailure(Origin origin_, const std::string& message, std::string help_)
      : Failure(FailureKind::bad_law, origin_, message, std::move(help_)) {}
  std::optional<double> argument; ///< the argument at which the law is bad
  Point x{};                      ///< and the place and time
  LawTime t{};
  std::optional<Expr> condition; ///< the comparison that turns too often
};

} // namespace hvi::solver
