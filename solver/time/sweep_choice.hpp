// With how many bits an entry the sweeps of a step read the factor: few while the extrapolation is
// good. Asked by the Stepper before a correction, told by it afterwards what came of that.
#pragma once

#include "solver/linear/factorisation.hpp"

#include <iosfwd>

namespace hvi::solver {

/// How one correction may sweep.
struct SweepLimits {
  SweepStorage forward = SweepStorage::full;
  /// Back with 32, with 48 bits where the contact unknowns move by no more than this part of their
  /// size; else in full.
  double most_single = -1.0, most_fine = -1.0;

  SweepStorage back(double moved) const {
    if (moved <= most_single) return SweepStorage::single;
    return moved <= most_fine ? SweepStorage::fine : SweepStorage::full;
  }
};

/// The error of a sweep back is proportional to what the contact unknowns move beyond the
/// extrapolation, that of a sweep forward to what the extrapolation leaves of the load. Both are
/// learnt: a correction must end within `target`, or a second pair of sweeps is due.
class SweepChoice {
public:
  explicit SweepChoice(double tolerance);

  /// Of the certificate: what a correction with a shortened factor must reach.
  double target() const { return target_; }
  /// Is a shortened factor worth its making, when so many steps are left?
  bool worthwhile(int steps_left) const;
  /// Do shortened factors fail too often?
  bool failed() const { return misses_ >= 4 && 4 * misses_ >= steps_; }
  /// For a correction of an extrapolated step; the steps before it moved about as far as this one.
  SweepLimits limits(bool contact) const;

  /// After the first correction of a step from its extrapolation, or of one without (infinity).
  void note_moved(double moved) { moved_ = moved; }
  /// With a shortened factor: it swept so, and its error was that.
  void learn(SweepStorage forward, SweepStorage back, double error);
  void count_step() { ++steps_; }

  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  double most(SweepStorage storage) const;

  double target_;
  double gain_single_ = 0.0, gain_fine_ = 0.0; ///< largest error of a sweep back, over `moved`
  double moved_ = 0.0;                         ///< of the last step
  int steps_ = 0, misses_ = 0;
  bool forward_single_ = true;
};

} // namespace hvi::solver
