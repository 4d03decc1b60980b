// Semismooth Newton on graph states: the active set method (active_set.cpp).
#pragma once

#include "solver/inequality/tangent_solver.hpp"

namespace hvi::solver {

/// Outcome of a method on fixed components; `left`: there is no solution on them, for points run
/// ever farther beyond the ends of theirs.
enum class MethodOutcome { solved, failed, indefinite, left };

class ActiveSetNewton {
public:
  ActiveSetNewton(TangentSolver& tangent, const InequalityOptions& options);
  MethodOutcome solve(Position& at, int limit, InequalityReport& report);

private:
  MethodOutcome step(Position& at, bool settled, InequalityReport& report);

  TangentSolver& tangent_;
  const InequalityOptions& options_;
  // Room for a solve.
  TangentStep step_;
  Vector dz_, trial_;
  std::vector<int> state_before_;
};

} // namespace hvi::solver
