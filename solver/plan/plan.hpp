// THE boundary: what the language hands to the engine. Plain aggregates: no syntax, nothing to
// parse again. A C++ program can fill one in by hand (examples/cpp/slab.cpp).
#pragma once

#include "solver/plan/options.hpp"
#include "solver/plan/problem.hpp"
#include "solver/plan/report.hpp"

#include <memory>
#include <string>

namespace hvi::solver {

struct Plan {
  Problem problem;       ///< what is stated
  SolverOptions options; ///< how it is solved
  ReportSpec report;     ///< what is asked of it
  /// Set: the run begins with the last state of this problem, which is one of the same unknowns on
  /// the same mesh and has the same laws or some of them.
  std::shared_ptr<const Plan> start{};
};

/// The whole plan in a readable, stable text (hvi-run dump --plan).
std::string to_string(const Plan& plan);

} // namespace hvi::solver
