// What a step did.
#pragma once

#include "solver/time/certificate.hpp"

#include <vector>

namespace hvi::solver {

struct StepResult {
  double equilibrium = 0.0; ///< componentwise backward error
  Inclusion inclusion;
  InequalityReport inequality; ///< of the last correction; iterations and events of all
  int corrections = 0;         ///< pairs of sweeps
  bool certified = false;
  /// It crossed unstable states: the branch ended, or where it was not followed, snap.hpp says so.
  bool snap = false;
  std::vector<double> branch_ends; ///< where, from 0 at the last state to 1 at this one
};

} // namespace hvi::solver
