// The state of a run; see run_state.hpp. Held by the Stepper.
#include "solver/step/run_state.hpp"

#include "solver/common/memory_room.hpp"
#include "solver/linear/mixed/mixed_solves.hpp"
#include "solver/step/start_laws.hpp"
#include "solver/step/start_motion.hpp"

namespace hvi::solver {
namespace {

/// What memories will hold must fit, and factors leave room for it.
Formulation& with_room_for_memories(const Plan& plan, Formulation& formulation,
                                    const Memory& memory) {
  const double bytes = history_bytes_to_come(plan, memory.reports(), formulation.layout().n_state);
  formulation.expect_memory(bytes);
  require_memory(bytes, "the fields its memories will hold");
  return formulation;
}

/// Rough ones, if wanted; beside the contact unknowns there may be next to nothing to solve for.
std::unique_ptr<CorrectionSolves> correction_solves(const Plan& plan,
                                                    const Formulation& formulation) {
  const Contact& contact = formulation.contact();
  const double tolerance = plan.options.tolerance;
  if (plan.options.reduced_precision && !formulation.reduced() && !contact.whole &&
      !formulation.operators().iterative)
    return mixed_solves(tolerance, !contact.none());
  return std::make_unique<CorrectionSolves>(tolerance);
}

} // namespace

RunState::RunState(const Plan& plan, const Discretisation& d)
    : formulation(formulate(plan, d)),
      evolution(plan, formulation->initial(), formulation->imposed()),
      balance(plan, d, with_room_for_memories(plan, *formulation, evolution.memory()), evolution),
      solver(plan, d, evolution, *formulation, balance, correction_solves(plan, *formulation)),
      rounding(plan.problem, *formulation, evolution, balance),
      checks(formulation->row_checks(plan)) {
  trial.d = trial.kd = trial.gap = Vector::Zero(formulation->layout().n_unknowns);
  trial.z = trial.dz = Vector::Zero(contact().n_rows());
  evolution.start();
  if (plan.problem.time.start) take_start(plan.problem, *this);
  if (in_motion(plan.problem))
    start_motion(plan, d, *this);
  else
    solver.equations.laws.states.start();
}

} // namespace hvi::solver
