// Where a step began, and what that says of the branch that its answer belongs to.
#pragma once

#include "solver/inequality/release.hpp"

namespace hvi::solver {

/// The last state's arguments, multipliers and places.
struct StepStart {
  Vector z, xi;
  std::vector<int> state;
};
void note_start(const ContactPoints& points, const InequalityState& io, StepStart& out);

/// Did the step go where another branch may have taken over?
bool may_have_left(const ContactPoints& points, const StepStart& start, const InequalityState& now);

/// The answer of a step while other branches are looked at.
struct StepAnswer {
  Position& at;
  const StepStart& start;
  Methods methods; ///< that may be used
  InequalityState& io;
  InequalityReport& report;
};
/// The place becomes the answer if it is certified, with the jumps that were crossed since the
/// start.
bool accept_answer(StepAnswer& step, double tolerance);

} // namespace hvi::solver
