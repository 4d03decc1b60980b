// See load_in_parts.hpp. Called by the StepSolver.
#include "solver/step/load_in_parts.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

/// Of the forces: what corrections leave in their first passes is far below.
constexpr double not_held = 1e-2;
constexpr double first_part = 0.25, smallest_part = 1.0 / 64.0;

bool holds(const StepResult& result) {
  return result.inequality.converged && result.equilibrium <= not_held;
}

} // namespace

void put_load_on_in_parts(EquationSolver& solver, const Contact& contact, Balance& balance,
                          StepMatrix& matrix, const InequalityState& start, StepEquation& equation,
                          Trial& trial, StepResult& out) {
  if (matrix.free_body() == nullptr || holds(out)) return;
  const Vector whole = equation.rhs;
  const Vector held = start.xi.size() == contact.force.cols() ? Vector(contact.force * start.xi)
                                                              : Vector::Zero(whole.size());
  const InequalityState failed = solver.laws.now;
  const Trial failed_trial = trial;
  solver.laws.now = start;
  InequalityState last = start;
  Vector d = Vector::Zero(trial.d.size());
  StepResult result = out; // whose iterations count
  for (double on = 0.0, part = first_part; on < 1.0;) {
    const double next = std::min(on + part, 1.0);
    equation.rhs = held + next * (whole - held);
    trial.d = d;
    balance.residual(equation, matrix, solver.laws.now.xi, trial);
    const int iterations = result.inequality.iterations, corrections = result.corrections;
    result = solver.solve(matrix, CorrectionStart::again, equation, trial);
    result.inequality.iterations += iterations;
    result.corrections += corrections;
    if (holds(result)) {
      on = next;
      last = solver.laws.now, d = trial.d;
    } else {
      part /= 2.0;
      if (part < smallest_part) break;
      solver.laws.now = last;
    }
  }
  equation.rhs = whole;
  if (holds(result)) {
    out = std::move(result);
    return;
  }
  solver.laws.now = failed, trial = failed_trial;
}

} // namespace hvi::solver
