// The state of a run; see run_state.hpp. Held by the Stepper.
#include "solver/time/run_state.hpp"

#include "solver/common/memory_room.hpp"

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

} // namespace

RunState::RunState(const Plan& plan, const Discretisation& d)
    : formulation(formulate(plan, d)),
      evolution(plan, formulation->initial(), formulation->imposed()),
      balance(plan, d, with_room_for_memories(plan, *formulation, evolution.memory()), evolution),
      solver(plan, d, evolution, *formulation, balance),
      rounding(plan.problem, *formulation, evolution, balance) {
  trial.d = trial.kd = trial.gap = Vector::Zero(formulation->layout().n_unknowns);
  trial.z = trial.dz = Vector::Zero(contact().n_rows());
  evolution.start();
}

} // namespace hvi::solver
