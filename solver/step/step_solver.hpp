// The solution of one step: an increment and multipliers from the last accepted state.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/body_tangent.hpp"
#include "solver/step/equation_solver.hpp"
#include "solver/step/refinement.hpp"

namespace hvi::solver {

class StepSolver {
public:
  /// Keeps references to all of them.
  StepSolver(const Plan& plan, const Discretisation& discretisation, const Evolution& evolution,
             Formulation& formulation, Balance& balance, std::unique_ptr<CorrectionSolves> solves);

  /// The matrix of step n with a factor.
  StepMatrix& matrix_for(int n);
  /// Solves step n and judges it on the rows of the steps' unknowns; equation.known is u_n then.
  /// `follow`: the branch of the last state is followed, for there may be several solutions.
  StepResult attempt(int n, StepMatrix& matrix, bool follow, StepEquation& equation, Trial& trial);
  /// After an attempt that failed: did it begin with an extrapolation, so that another one without
  /// it may succeed? Then the extrapolation is dropped.
  bool begin_anew(int n);
  /// The attempt ends the step. Takes trial.kd and leaves any vector in its place.
  void accept(int n, StepMatrix& matrix, const StepResult& result, Trial& trial);

  void save(std::ostream& out) const;
  void restore(std::istream& in);

  EquationSolver equations;
  Refinement refinement;

private:
  void begin(int n, StepMatrix& matrix, bool follow, StepEquation& equation, Trial& trial);
  double renew(int n, StepMatrix& matrix, StepEquation& equation, Trial& trial);
  /// Forms become those of the states that step n begins with.
  void take_first_states(int n);

  const Plan& plan_;
  const Evolution& evolution_;
  Formulation& formulation_;
  Balance& balance_;
  std::optional<BodyTangent> body_; ///< where states change forms
};

} // namespace hvi::solver
