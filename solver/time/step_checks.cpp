// States on the contact unknowns, and the checks on all rows that they owe; see step.hpp.
#include "solver/time/reduce.hpp"
#include "solver/time/step.hpp"

namespace hvi::solver {

/// Where all tensors are multiples of one: states become [contact unknowns; modes].
void Stepper::reduce_if_possible() {
  obstacle_ = proportional_obstacle(plan_, operators_, contact_, *loads_, layout_);
  if (!obstacle_.empty()) return;
  try {
    if (!live_on_contact(layout_, operators_, contact_, *loads_, u_)) {
      obstacle_ = "its matrix is ill-conditioned, and steps are refined on all unknowns";
      return;
    }
  } catch (const NotFactorable&) { // the first step will say which motion is free
    obstacle_ = "its matrix has no factor";
    return;
  }
  checked_ = checked_steps(plan_, grid_.steps());
  never_shortened_ = true; // there is next to nothing to sweep
}

Interior::Question Stepper::question(int n) const {
  return {stress_, coefficients(n)[0] * d_, load_, inequality_.xi};
}

/// The backward error of step n on all rows, of the fields that a report would see. The last step
/// makes the checks that were put off, too.
double Stepper::equilibrium_of_all(int n) {
  if (checks_wait_ && n == grid_.steps()) {
    waiting_steps_.push_back(n);
    waiting_.push_back(question(n));
    settle_checks();
    const double error = late_errors_.back().second;
    late_errors_.pop_back();
    return error;
  }
  // By the same sums as many at once: a check that could not wait gives the same bits.
  const Interior::Question asked[] = {question(n)};
  return layout_.interior->equilibria(asked, 0.1 * plan_.options.tolerance).front();
}

/// After a step with a certificate on the contact rows. A check waits for others, and not for long:
/// tables reach the disk up to the step before it.
void Stepper::put_off_check(int n) {
  constexpr int longest_wait = 1024; // steps
  if (checked_[n] != 0 && n < grid_.steps()) {
    waiting_steps_.push_back(n);
    waiting_.push_back(question(n));
  }
  if (waiting_.empty()) return;
  const bool full = waiting_.size() + 1 == static_cast<std::size_t>(Interior::most_steps);
  if (full || n - waiting_steps_.front() == longest_wait) settle_checks();
}

/// All checks that wait, in one pass. A last step that fails is no late one.
void Stepper::settle_checks() {
  const double tolerance = plan_.options.tolerance;
  const auto errors = layout_.interior->equilibria(waiting_, 0.1 * tolerance);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    late_errors_.emplace_back(waiting_steps_[k], errors[k]);
    if (!(errors[k] <= tolerance) && waiting_steps_[k] < grid_.steps()) throw LateCheck();
  }
  waiting_steps_.clear(), waiting_.clear();
}

void Stepper::make_checks() {
  if (!waiting_.empty()) settle_checks();
}

} // namespace hvi::solver
