// The solution of the equation of a step, for given bounds of coupled laws; and what is kept for it
// from step to step.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/corrector.hpp"
#include "solver/step/step_laws.hpp"
#include "solver/step/step_matrices.hpp"
#include "solver/step/step_result.hpp"
#include "solver/step/warm_start.hpp"
#include "solver/step/work.hpp"

namespace hvi::solver {

/// Where the corrections of a step begin.
enum class CorrectionStart {
  predicted,        ///< at an extrapolation where there is one, else at the last state
  again,            ///< at the trial: that of the same step with other laws
  again_with_bounds ///< there, with the bounds of coupled laws unknown, too
};

/// Corrects the increment until what is left of the equation is small enough.
class EquationSolver {
public:
  /// Keeps references to formulation, evolution and balance.
  EquationSolver(const Plan& plan, const Discretisation& discretisation, Formulation& formulation,
                 const Evolution& evolution, Balance& balance,
                 std::unique_ptr<CorrectionSolves> solves);

  StepResult solve(StepMatrix& matrix, CorrectionStart start, StepEquation& equation, Trial& trial);

  /// Adds what matrices and solves cost to the counters and phases of a run.
  void account(WorkCounters& work, Timing& timing) const;
  void save(std::ostream& out) const;
  void restore(std::istream& in);

  StepLaws laws;
  StepMatrices matrices;
  WarmStart warm_start;
  Corrector corrector;
  std::unique_ptr<CorrectionSolves> solves; ///< never null

private:
  EquationResidual judge(StepMatrix& matrix, const StepEquation& equation, Trial& trial,
                         StepResult& out);
  EquationResidual without_rounding(StepMatrix& matrix, const StepEquation& equation, Trial& trial,
                                    const EquationResidual& left);

  double tolerance_;
  Formulation& formulation_;
  const Evolution& evolution_;
  Balance& balance_;
};

} // namespace hvi::solver
