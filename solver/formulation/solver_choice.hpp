// Which linear solver a run takes, and what each would cost: predicted from the size of the steps
// before the first of them, without a factor.
#pragma once

#include "solver/common/memory_room.hpp"
#include "solver/discrete/chosen_solver.hpp"
#include "solver/discrete/contact.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/factor_estimate.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/plan/plan.hpp"

namespace hvi::solver {

/// What costs are predicted from.
struct StepSizes {
  double unknowns = 0, entries = 0; ///< of K
  double contact = 0;               ///< unknowns that laws touch
  FactorEstimate factor;            ///< of K, those last
  int matrices = 1, steps = 1;
  bool symmetric = true;
  bool one_matrix = false; ///< the steps are solved for the contact unknowns alone
  bool rubs = false;       ///< friction: points stick and slip
  bool several = false;    ///< unknowns
  bool singles = false;    ///< the factor is in single precision
};

struct SolverCost {
  double bytes = 0, seconds = 0; ///< beyond what is held already; of CPU time
};

struct SolverCosts {
  SolverCost direct, iterative;
};
SolverCosts predicted_costs(const StepSizes& sizes);

/// `contact`: with its own unknowns only.
StepSizes sizes_of_steps(const Plan& plan, const Discretisation& discretisation,
                         const StateLayout& layout, const Operators& operators,
                         const Contact& contact);

/// By what was asked for. `obstacle`: why iterations cannot solve it, or empty. Where neither fits
/// the direct one is taken, which says so.
ChosenSolver choose_solver(LinearSolver asked, const SolverCosts& costs,
                           const std::string& obstacle, const MemoryRoom& room);

/// The choice for a run. The costs are predicted where they may decide.
ChosenSolver choose_solver(const Plan& plan, const Discretisation& discretisation,
                           const StateLayout& layout, const Operators& operators,
                           const Contact& contact);

} // namespace hvi::solver
