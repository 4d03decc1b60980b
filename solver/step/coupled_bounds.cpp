// See coupled_bounds.hpp. Called by the StepSolver.
#include "solver/step/coupled_bounds.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

/// The fixed point of coupled bounds goes on while so many passes make its error so much smaller.
constexpr int passes_to_judge = 8;
constexpr double falls_by_passes = 0.1;

} // namespace

void couple_bounds(EquationSolver& solver, double tolerance, StepMatrix& matrix,
                   const InequalityState* path_start, StepEquation& equation, Trial& trial,
                   StepResult& out) {
  // What is left of the bounds; of a body that laws alone hold also of its balance.
  const auto error_of = [&] {
    const double error = solver.laws.settle_bounds(equation.n, equation.known, trial.d, trial.z);
    return matrix.free_body() == nullptr ? error : std::max(error, out.equilibrium);
  };
  double error = error_of();
  const auto again = [&](CorrectionStart start) {
    if (path_start != nullptr) {
      auto& now = solver.laws.now;
      now.z_before = path_start->z_before;
      now.xi_before = path_start->xi, now.state_before = path_start->state;
    }
    // With smaller bounds such a body has run away; where it was these may hold it.
    if (matrix.free_body() != nullptr && out.equilibrium > tolerance) {
      trial.d.setZero();
      trial.gap = equation.rhs;
    }
    const int iterations = out.inequality.iterations, corrections = out.corrections;
    out = solver.solve(matrix, start, equation, trial);
    out.inequality.iterations += iterations;
    out.corrections += corrections;
    error = error_of();
    return error <= tolerance;
  };
  if (error <= tolerance && out.inequality.converged) return;
  double before = error;
  for (int pass = 1; out.inequality.converged; ++pass) {
    if (again(CorrectionStart::again) && out.inequality.converged) return;
    if (pass % passes_to_judge != 0) continue;
    if (!(error < falls_by_passes * before)) break; // infinite ones do not fall, either
    before = error;
  }
  if (!again(CorrectionStart::again_with_bounds) && out.inequality.verdict.empty())
    out.inequality.verdict =
        "the laws do not hold with the bounds that the multipliers of the same state make";
}

} // namespace hvi::solver
