// What a run knows after its last accepted step, and the equations that it solves. Results read it.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/rounding_estimate.hpp"
#include "solver/step/step_solver.hpp"

namespace hvi::solver {

struct RunState {
  RunState(const Plan& plan, const Discretisation& discretisation);
  RunState(const RunState&) = delete; // its parts refer to each other
  RunState& operator=(const RunState&) = delete;

  const Contact& contact() const { return formulation->contact(); }
  const Vector& xi() const { return solver.equations.laws.now.xi; }
  const Vector& states() const { return solver.equations.laws.states.accepted(); }

  std::unique_ptr<Formulation> formulation; ///< never null
  Evolution evolution;
  Balance balance;
  StepSolver solver;
  RoundingEstimate rounding;
  std::unique_ptr<RowChecks> checks; ///< null: every step is checked on all rows, by itself
  StepEquation equation;             ///< of the last attempted step,
  Trial trial;                       ///< and what was tried
};

} // namespace hvi::solver
