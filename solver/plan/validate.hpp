// Does a plan hold together? What the language makes does; a plan filled in by hand may not.
#pragma once

#include "solver/plan/plan.hpp"

#include <vector>

namespace hvi::solver {

/// Every index, shape, count and variable of the plan that names something it does not have, all of
/// them at once; empty: the engine can read all of it. `dim`: of the mesh (1 to 3). Says nothing of
/// what `discretise` says when it makes mesh, parts and space of the plan, nor of the mathematics.
std::vector<Failure> validate(const Plan& plan, int dim);

/// The same of each piece: what is stated, how it is solved, what is asked of it.
std::vector<Failure> validate(const Problem& problem, int dim);
std::vector<Failure> validate(const SolverOptions& options);
std::vector<Failure> validate(const ReportSpec& report, const Problem& problem, int dim);

} // namespace hvi::solver
