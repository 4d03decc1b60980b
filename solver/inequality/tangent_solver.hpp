// The linear solves of Newton's steps: (S + H) dc = residual, H from the linearised graphs.
#pragma once

#include "solver/inequality/position.hpp"

namespace hvi::solver {

struct TangentStep {
  Vector dc;
  Vector rest; ///< residual - (S + H) dc, which resting points take; 0 for solves by a factor
  Vector s_dc; ///< S dc, where it is known
  double before = 0.0; ///< |residual|, of solves by iterations
  bool product_known = false;
  bool of_small_rows = false; ///< was solved for the rows that the norm of all does not see
};

class TangentSolver {
public:
  virtual ~TangentSolver() = default;
  /// `settled`: no point changed its place in the last step of Newton's, so that digits pay; `out`
  /// still is that step.
  /// False: S + H is not (positive definite and) regular. dc is not finite where no step was found.
  virtual bool solve(const Position& at, const Vector& residual, bool settled,
                     InequalityReport& report, TangentStep& out) = 0;
};

} // namespace hvi::solver
