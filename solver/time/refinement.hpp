// Iterative refinement of a step in extended precision, for matrices that are ill-conditioned.
//
// J. Demmel, Y. Hida, W. Kahan, X. S. Li, S. Mukherjee, E. J. Riedy, Error bounds from
// extra-precise iterative refinement, ACM Trans. Math. Softw. 32 (2006) 325-351: residuals in twice
// the working precision make the solution of an ill-conditioned system as accurate as its matrix,
// as long as the factor gains at all.
#pragma once

#include "solver/time/balance.hpp"
#include "solver/time/step_result.hpp"

namespace hvi::solver {

class Refinement {
public:
  /// Keeps references to all of them.
  Refinement(const Problem& problem, const Evolution& evolution, Balance& balance, Contact& contact)
      : problem_(problem), evolution_(evolution), balance_(balance), contact_(contact) {}

  /// Is every step refined?
  bool on() const { return on_; }
  /// The largest relative size of a step's last correction.
  double last_correction() const { return last_correction_; }

  /// Asked of each new factor: a pair of triangular solves beside it. True: steps are refined from
  /// now on.
  bool begins_with(StepMatrix& matrix);
  /// The increment and the multipliers of an attempted step, corrected until that moves nothing.
  /// The laws are solved about the present state, so their unknowns are corrections, too. Throws
  /// Failure(mostly_rounding).
  void refine(StepMatrix& matrix, const StepEquation& equation, Trial& trial, InequalityState& laws,
              StepResult& out);

  void save(StateWriter& w) const;
  void restore(StateReader& r);

private:
  void prepare_laws(int n, const Vector& u, const Vector* d, const Vector& xi);

  const Problem& problem_;
  const Evolution& evolution_;
  Balance& balance_;
  Contact& contact_;
  bool on_ = false;
  double last_correction_ = 0.0;
};

} // namespace hvi::solver
