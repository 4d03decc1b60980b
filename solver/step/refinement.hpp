// Iterative refinement of a step in extended precision, for matrices that are ill-conditioned.
//
// J. Demmel, Y. Hida, W. Kahan, X. S. Li, S. Mukherjee, E. J. Riedy, Error bounds from
// extra-precise iterative refinement, ACM Trans. Math. Softw. 32 (2006) 325-351: residuals in twice
// the working precision make the solution of an ill-conditioned system as accurate as its matrix,
// as long as the factor gains at all.
#pragma once

#include "solver/step/balance.hpp"
#include "solver/step/corrector.hpp"
#include "solver/step/step_laws.hpp"
#include "solver/step/step_result.hpp"

namespace hvi::solver {

/// The equation of a step in extended precision.
class PreciseEquation {
public:
  /// Keeps references to all of them.
  PreciseEquation(const Formulation& formulation, const Evolution& evolution, Balance& balance,
                  const StepEquation& equation);
  /// gap = f_n - sum_b T_b (gamma_b d - known_b); returns the backward error of gap - G^T W xi.
  double gap(const StepMatrix& matrix, const Vector& d, const Vector& xi, Vector& gap);

private:
  const Formulation& formulation_;
  Balance& balance_;
  int step_;
  std::vector<Vector> known_; ///< on every base matrix, negative
};

class Refinement {
public:
  /// Keeps references to all of them.
  Refinement(const Problem& problem, const Formulation& formulation, const Evolution& evolution,
             Balance& balance)
      : problem_(problem), formulation_(formulation), evolution_(evolution), balance_(balance) {}

  /// Is every step refined?
  bool on() const { return on_; }
  /// The largest relative size of a step's last correction.
  double last_correction() const { return last_correction_; }

  /// Asked of each new factor: a pair of triangular solves beside it. True: steps are refined from
  /// now on.
  bool begins_with(const StepMatrix& matrix);
  /// From now on, whatever the factor.
  void begin() { on_ = true; }
  /// The increment and the multipliers of an attempted step, corrected until that moves nothing.
  /// The laws are solved about the present state, so their unknowns are corrections, too. Throws
  /// Failure(mostly_rounding).
  void refine(const StepMatrix& matrix, const StepEquation& equation, Corrector& corrector,
              StepLaws& step_laws, Trial& trial, StepResult& out);

  void save(StateWriter& w) const;
  void restore(StateReader& r);

private:
  const Problem& problem_;
  const Formulation& formulation_;
  const Evolution& evolution_;
  Balance& balance_;
  bool on_ = false;
  double last_correction_ = 0.0;
};

} // namespace hvi::solver
