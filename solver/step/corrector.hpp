// One correction of the increment of a step.
#pragma once

#include "solver/formulation/step_matrix.hpp"
#include "solver/linear/correction_solves.hpp"

namespace hvi::solver {

/// What a correction did.
struct Correction {
  InequalityReport report;
  double moved = 0.0;  ///< max |c' - c| / max |c'|; without laws 100 max |d' - d| / max |d'|
  double change = 1.0; ///< max |d' - d| / max |d'|
};

class Corrector {
public:
  /// Keeps a reference to contact. `separate`: other unknowns have no part in S c.
  Corrector(const Contact& contact, bool separate);

  /// One correction of the increment d with contact part c, given gap = b - K d: solves
  ///     S c' + G_c^T W xi' = S c + (gap condensed),   xi' in dj(G_c c' + offset)
  /// and adds to d the x with K x = gap on the interior and c' - c on the contact unknowns. `state`
  /// is where the search starts, and then holds (c', xi'). With an exact factor one correction of
  /// d = 0 is the solution; more of them are iterative refinement. `rhs`: gap + K d where the
  /// caller has it, else null. `couple_bounds`: finds the bounds of coupled laws, too.
  Correction correct(const StepMatrix& matrix, const Vector& gap, const Vector* rhs,
                     bool couple_bounds, CorrectionSolves& solves, InequalityState& state,
                     Vector& d);

  /// The first correction: the same with d = 0, whatever d holds, by the factor's own solves.
  InequalityReport start(const StepMatrix& matrix, const Vector& gap, InequalityState& state,
                         Vector& d);

  double seconds_inequality = 0, seconds_triangular = 0; ///< of the clock on the wall, so far

private:
  Correction solve(const StepMatrix& matrix, const Vector& gap, const Vector* rhs,
                   bool couple_bounds, CorrectionSolves& solves, InequalityState& state);
  void add_part_of(const Vector& c, const StepMatrix& matrix, const Vector& gap, const Vector* rhs,
                   InequalityState& state);

  const Contact& contact_;
  bool separate_;
  // Room within a correction: what is condensed, the correction, d on the contact unknowns, S d.
  Vector y_, r_, x_, c_, product_;
};

} // namespace hvi::solver
