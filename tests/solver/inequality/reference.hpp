// A slow, independent solver of the reduced inequality: nonlinear Gauss-Seidel on the energy, or
// alternating directions. Convex problems only.
#pragma once

#include "solver/inequality/inequality.hpp"

namespace hvi::solver::test {

bool reference_solve(const ReducedProblem& problem, const DenseMatrix& s, const Vector& r,
                     double tolerance, InequalityState& state);

} // namespace hvi::solver::test
