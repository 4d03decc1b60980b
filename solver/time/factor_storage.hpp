// Whether the factor of a step is stored once more with fewer bits an entry: triangular solves are
// bound by reading it, and fewer bits halve that where the extrapolation from the last steps is so
// good that one pair of solves is enough.
#pragma once

#include "solver/time/precision_choice.hpp"
#include "solver/time/step_matrices.hpp"

namespace hvi::solver {

class FactorStorage {
public:
  FactorStorage(bool allowed, double tolerance)
      : tolerance_(tolerance), allowed_(allowed), choice_(tolerance) {}

  /// From now on all solves are in double precision.
  void forbid() { allowed_ = false, reduced_ = nullptr; }
  /// What corrections with this matrix must reach.
  double target(const StepMatrix& matrix) const {
    return reduced_ == &matrix ? choice_.target() : tolerance_;
  }
  /// The precision that the first correction of a step may use; `contact`: laws act.
  PrecisionLimits begin(const StepMatrix& matrix, bool predicted, bool contact);
  /// What the first correction of a predicted step left; `exact`: the factor is that of the step's
  /// own matrix.
  void learn(const Correction& correction, bool exact, double error);
  /// After an accepted step. `predictable`: the next one can be extrapolated.
  void choose(StepMatrix& matrix, bool predictable, int steps_left);

  void save(std::ostream& out, const StepMatrices& matrices) const;
  void restore(std::istream& in, const StepMatrices& matrices);

private:
  double tolerance_;
  bool allowed_;
  const StepMatrix* reduced_ = nullptr; ///< whose factor is there once more
  PrecisionChoice choice_;
};

} // namespace hvi::solver
