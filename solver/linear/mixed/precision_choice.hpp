// In which precision the triangular solves of a step read the factor: a reduced one
// while the extrapolation is good. MixedSolves asks before a correction and reports its error
// afterwards.
#pragma once

#include "solver/linear/mixed/precision.hpp"

#include <iosfwd>

namespace hvi::solver {

/// The precision allowed for one correction.
struct PrecisionLimits {
  FactorPrecision forward = FactorPrecision::full;
  /// Back with 32, with 48 bits where the contact unknowns move by no more than this part of their
  /// size; else in full.
  double most_single = -1.0, most_fine = -1.0;

  FactorPrecision back(double moved) const {
    if (moved <= most_single) return FactorPrecision::single;
    return moved <= most_fine ? FactorPrecision::fine : FactorPrecision::full;
  }
};

/// The error of a backward solve in reduced precision is proportional to how far the contact
/// unknowns move beyond the extrapolation, that of a forward solve to the part of the load that the
/// extrapolation leaves. Both factors are estimated from earlier steps: a correction must end
/// within `target`, or a second forward and backward solve is needed.
class PrecisionChoice {
public:
  explicit PrecisionChoice(double tolerance);

  /// The error that a correction in reduced precision must reach, from the certificate's tolerance.
  double target() const { return target_; }
  /// Does a reduced-precision factor pay, when so many steps are left?
  bool worthwhile(int steps_left) const;
  /// Do reduced-precision factors fail too often?
  bool failed() const { return known_.misses >= 4 && 4 * known_.misses >= known_.steps; }
  /// For a correction of an extrapolated step; the steps before it moved about as far as this one.
  PrecisionLimits limits(bool contact) const;

  /// After the first correction of a step from its extrapolation, or of one without (infinity).
  void note_moved(double moved) { known_.moved = moved; }
  /// After a correction in reduced precision: what was used, and its error.
  void learn(FactorPrecision forward, FactorPrecision back, double error);
  void count_step() { ++known_.steps; }

  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  double most(FactorPrecision storage) const;

  /// What earlier steps showed.
  struct Experience {
    double gain_single = 0.0, gain_fine = 0.0; ///< largest error of a backward solve, over `moved`
    double moved = 0.0;                        ///< of the last step
    int steps = 0, misses = 0;
    bool forward_single = true;
  };

  double target_;
  Experience known_;
};

} // namespace hvi::solver
