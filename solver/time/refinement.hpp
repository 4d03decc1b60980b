// Iterative refinement of a step in extended precision, for matrices that are ill-conditioned.
//
// J. Demmel, Y. Hida, W. Kahan, X. S. Li, S. Mukherjee, E. J. Riedy, Error bounds from
// extra-precise iterative refinement, ACM Trans. Math. Softw. 32 (2006) 325-351: residuals in twice
// the working precision make the solution of an ill-conditioned system as accurate as its matrix,
// as long as the factor gains at all.
#pragma once

#include "solver/time/balance.hpp"
#include "solver/time/corrector.hpp"
#include "solver/time/step_laws.hpp"
#include "solver/time/step_result.hpp"

namespace hvi::solver {

class Refinement {
public:
  /// Keeps references to all three.
  Refinement(const Problem& problem, Balance& balance, const Contact& contact)
      : problem_(problem), balance_(balance), contact_(contact) {}

  /// Is every step refined?
  bool on() const { return on_; }
  /// The largest relative size of a step's last correction.
  double last_correction() const { return last_correction_; }

  /// Asked of each new factor: a pair of triangular solves beside it. True: steps are refined from
  /// now on.
  bool begins_with(const StepMatrix& matrix);
  /// The increment and the multipliers of an attempted step, corrected until that moves nothing.
  /// The laws are solved about the present state, so their unknowns are corrections, too. Throws
  /// Failure(mostly_rounding).
  void refine(const StepMatrix& matrix, const StepEquation& equation, Corrector& corrector,
              StepLaws& step_laws, Trial& trial, StepResult& out);

  void save(StateWriter& w) const;
  void restore(StateReader& r);

private:
  const Problem& problem_;
  Balance& balance_;
  const Contact& contact_;
  bool on_ = false;
  double last_correction_ = 0.0;
};

} // namespace hvi::solver
