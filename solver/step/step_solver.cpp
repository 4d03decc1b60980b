// The solution of one step; see step_solver.hpp. Called by the Stepper.
#include "solver/step/step_solver.hpp"

#include "solver/step/coupled_bounds.hpp"
#include "solver/step/coupled_readings.hpp"
#include "solver/step/load_in_parts.hpp"
#include "solver/step/state_coupling.hpp"

#include <optional>
#include <utility>

namespace hvi::solver {

StepSolver::StepSolver(const Plan& plan, const Discretisation& discretisation,
                       const Evolution& evolution, Formulation& formulation, Balance& balance,
                       std::unique_ptr<CorrectionSolves> solves)
    : equations(plan, discretisation, formulation, evolution, balance, std::move(solves)),
      refinement(plan.problem, formulation, evolution, balance), plan_(plan), evolution_(evolution),
      formulation_(formulation), balance_(balance) {
  if (formulation.changes())
    body_.emplace(plan.problem, discretisation, formulation, evolution, equations.laws.states);
}

/// Forms and loads that states change begin at the last ones, and at the time of the step; with
/// such forms every step has its own factor.
StepMatrix& StepSolver::matrix_for(int n) {
  if (formulation_.changes()) {
    if (evolution_.scheme().looks_back()) {
      equations.laws.states.give_up(); // what the step before has left
      formulation_.take_states();
      balance_.note_past(n);
    }
    take_first_states(n);
  }
  const auto [matrix, fresh] = equations.matrices.find(n, evolution_.factors(n));
  if (fresh && !formulation_.reduced() && refinement.begins_with(matrix)) {
    equations.solves->stop();
    equations.warm_start.clear();
  }
  return matrix;
}

void StepSolver::take_first_states(int n) {
  equations.laws.states.begin(n);
  formulation_.take_states();
}

/// The equation of the step, and its laws at the state that it begins with.
void StepSolver::begin(int n, StepMatrix& matrix, bool follow, StepEquation& equation,
                       Trial& trial) {
  Contact& contact = formulation_.contact();
  StepLaws& laws = equations.laws;
  equation.n = n;
  balance_.known_state(n, equation.known);
  contact.least_reach = balance_.rounding_of_largest();
  for (double& reach : contact.least_reach) reach /= plan_.options.tolerance;
  equations.warm_start.find_change(n, balance_.coefficients(n), matrix, equation, trial.d);
  // Where a branch ends, K_n itself has to say.
  if (formulation_.changes_forms() || (follow && !equation.exact())) {
    equations.matrices.factor(n, evolution_.factors(n), matrix);
    equation.change.setZero();
  }
  balance_.find_right_hand_side(equation);
  laws.states.begin(n);
  laws.read_solution(n, equation.known);
  laws.prepare(n, equation.known);
  if (const FreeBody* const body = matrix.free_body())
    refuse_unbalanced(*body, contact, plan_.problem, equation.rhs, evolution_.grid().t(n));
}

StepResult StepSolver::attempt(int n, StepMatrix& matrix, bool follow, StepEquation& equation,
                               Trial& trial) {
  Contact& contact = formulation_.contact();
  StepLaws& laws = equations.laws;
  begin(n, matrix, follow, equation, trial);
  const double tolerance = plan_.options.tolerance;
  std::optional<InequalityState> path_start;
  if (follow) {
    laws.start_path(n);
    if (contact.coupled || !contact.readings.empty() || !laws.states.none()) path_start = laws.now;
  }
  const auto* const start = path_start ? &*path_start : nullptr;
  std::optional<InequalityState> held;
  if (matrix.free_body() != nullptr) held = laws.now;
  const auto solve = [&](CorrectionStart from) {
    auto result = equations.solve(matrix, from, equation, trial);
    if (held && from == CorrectionStart::predicted)
      put_load_on_in_parts(equations, contact, balance_, matrix, *held, equation, trial, result);
    if (contact.coupled)
      couple_bounds(equations, tolerance, matrix, start, equation, trial, result);
    if (!laws.states.none())
      couple_states(
          plan_.problem, equations, contact, tolerance, matrix, start, body_ ? &*body_ : nullptr,
          [&] { return renew(n, matrix, equation, trial); }, equation, trial, result);
    return result;
  };
  auto out = solve(CorrectionStart::predicted);
  if (!contact.readings.empty())
    couple_readings(laws, contact, tolerance, start, equation, trial, solve, out);
  const bool too_far = matrix.free_body() != nullptr && out.equilibrium > tolerance;
  if (too_far && out.inequality.converged) refinement.begin();
  if (refinement.on()) {
    refinement.refine(matrix, equation, equations.corrector, laws, trial, out);
    if (out.equilibrium > tolerance && equation.exact())
      out.equilibrium =
          balance_.error_beside_rounding(equation, matrix, laws.now.xi, trial, tolerance);
    if (!contact.readings.empty()) {
      laws.read_solution(n, equation.known, &trial.d);
      laws.prepare(n, equation.known);
    }
    if (!laws.states.none() && !formulation_.changes())
      follow_refined(equations, contact, tolerance, equation, trial);
  }
  equation.known.head(trial.d.size()) += trial.d; // now u_n
  out.inclusion = laws.inclusion(n, equation.known, trial.d, trial.z);
  if (!laws.states.none()) out.states = laws.state_error(equation.known, trial.d);
  const FreeBody* const body = matrix.free_body();
  if (body != nullptr && !(out.inequality.converged && out.equilibrium <= tolerance)) {
    std::string& verdict = out.inequality.verdict;
    verdict += (verdict.empty() ? "" : "; ") + runaway(*body, trial.d);
  }
  return out;
}

/// The equation with the forms and loads of the states at hand.
/// Returns what the increment leaves of it.
double StepSolver::renew(int n, StepMatrix& matrix, StepEquation& equation, Trial& trial) {
  if (!formulation_.changes()) return 0.0;
  formulation_.take_states();
  if (formulation_.changes_forms()) equations.matrices.factor(n, evolution_.factors(n), matrix);
  balance_.find_right_hand_side(equation);
  return balance_.residual(equation, matrix, equations.laws.now.xi, trial).error;
}

bool StepSolver::begin_anew(int n) {
  if (!equations.warm_start.ready()) return false;
  equations.warm_start.clear();
  equations.laws.give_up();
  if (formulation_.changes()) take_first_states(n); // the attempt left others
  return true;
}

void StepSolver::accept(int n, StepMatrix& matrix, const StepResult& result, Trial& trial) {
  equations.laws.accept(n);
  const auto& grid = evolution_.grid();
  auto& warm_start = equations.warm_start;
  // Nothing is smooth across a jump.
  if (grid.is_static() || refinement.on() || formulation_.changes() || result.snap ||
      result.inequality.events > 0)
    return warm_start.clear();
  warm_start.note(n, matrix, trial, equations.laws.now.xi);
  if (matrix.factorisation())
    equations.solves->accept(matrix.k(), *matrix.factorisation(), warm_start.ready(),
                             grid.steps() - n);
}

void StepSolver::save(std::ostream& out) const {
  equations.save(out);
  StateWriter w(out);
  balance_.save(w);
  refinement.save(w);
}

void StepSolver::restore(std::istream& in) {
  equations.restore(in);
  StateReader r(in, {});
  balance_.restore(r);
  refinement.restore(r);
}

} // namespace hvi::solver
