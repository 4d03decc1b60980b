// The solution of one step: an increment and multipliers from the last accepted state.
#pragma once

#include "solver/time/balance.hpp"
#include "solver/time/predictor.hpp"
#include "solver/time/refinement.hpp"
#include "solver/time/step_matrices.hpp"
#include "solver/time/step_result.hpp"

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
  bool can_begin_anew();
  /// The attempt ends the step. Takes trial.kd and leaves any vector in its place.
  void accept(int n, StepMatrix& matrix, const StepResult& result, Trial& trial);
  /// The last accepted step's multipliers hold again.
  void give_up() { laws_ = accepted_; }

  /// The laws' unknowns: of the last attempt; of the last accepted step.
  const InequalityState& laws() const { return laws_; }
  const InequalityState& accepted() const { return accepted_; }
  const Refinement& refinement() const { return refinement_; }
  const StepMatrices& matrices() const { return matrices_; }
  const CorrectionSolves& solves() const { return *solves_; }

  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  /// What laws see of the state u with the increment d (Evolution::law_fields).
  LawFields law_fields(int n, const Vector& u, const Vector* d) const {
    return evolution_.law_fields(n, contact_.other_fields, u, d);
  }
  void find_change(int n, const StepMatrix& matrix, StepEquation& equation, Trial& trial) const;
  bool continues(int n, const StepMatrix& matrix) const;
  bool predict(int n, const StepMatrix& matrix, const StepEquation& equation, Trial& trial);
  void guess_from(const Vector& d);
  void drop_guess();
  /// Where the corrections of a step begin.
  enum class Start {
    predicted,        ///< at an extrapolation where there is one, else at the last state
    again,            ///< at the trial: that of the same step with other laws
    again_with_bounds ///< there, with the bounds of coupled laws unknown, too
  };
  StepResult correct(StepMatrix& matrix, Start start, StepEquation& equation, Trial& trial);
  double bounds_error(const StepEquation& equation, Trial& trial);
  void couple_bounds(StepMatrix& matrix, const InequalityState* path_start, StepEquation& equation,
                     Trial& trial, StepResult& out);

  const Plan& plan_;
  const Evolution& evolution_;
  Formulation& formulation_;
  Contact& contact_;
  Balance& balance_;
  StepMatrices matrices_;
  Predictor predictor_;
  std::unique_ptr<CorrectionSolves> solves_;
  Refinement refinement_;
  InequalityState laws_, accepted_;
  Vector c_guess_, xi_guess_, state_; ///< room for guesses, and within a call
};

} // namespace hvi::solver
