// What a step did.
#pragma once

#include "solver/discrete/certificate.hpp"
#include "solver/discrete/memory.hpp"
#include "solver/step/point_states.hpp"

#include <optional>
#include <variant>
#include <vector>

namespace hvi::solver {

/// A check that was put off found a step without a certificate: the run starts again and makes each
/// check in its step, so that it ends there with what came before.
struct LateCheck {};
/// A step was not certified with the jumps across pairs as unknowns: a body that rests, or all but
/// rests, while another one moves gets rounding of the other from a factor that joins them. A run
/// starts again with the contact unknowns of both sides.
struct JumpsRefused {};
/// A step on the contact unknowns was not certified on all rows: those of a body that is at rest,
/// or back where it was, hold rounding, which only increments of all unknowns tell from errors. A
/// run starts again on all unknowns.
struct RowsRefused {};
/// A step was not certified with a factor in single precision: a run starts again with one in
/// double precision.
struct SinglesRefused {};
/// Why nothing that was computed so far is a result: the run starts again in another way.
using Restart =
    std::variant<MemoryMistrust, HorizonEnd, LateCheck, JumpsRefused, RowsRefused, SinglesRefused>;

struct StepResult {
  double equilibrium = 0.0; ///< componentwise backward error
  Inclusion inclusion;
  StateError states;
  InequalityReport inequality; ///< of the last correction; iterations and events of all
  int corrections = 0;         ///< pairs of a forward and a backward solve
  bool certified = false;
  std::optional<Restart> restart; ///< set: nothing else of this result is
  /// It crossed unstable states: the branch ended, or where it was not followed, snap.hpp says so.
  bool snap = false;
  int not_followed =
      -1; ///< a state that may have jumped: the step was not followed from the last one
  std::vector<double> branch_ends; ///< where, from 0 at the last state to 1 at this one
};

} // namespace hvi::solver
