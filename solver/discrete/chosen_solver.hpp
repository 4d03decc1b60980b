// Which linear solver a run has, and why.
#pragma once

#include "solver/plan/options.hpp"

#include <string>

namespace hvi::solver {

/// Direct or iterative.
struct ChosenSolver {
  LinearSolver solver = LinearSolver::direct;
  std::string why; ///< empty: it was asked for, or nothing was
};

} // namespace hvi::solver
