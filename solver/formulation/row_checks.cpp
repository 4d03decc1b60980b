// Checks on all rows; see row_checks.hpp. Called by the Stepper.
#include "solver/formulation/row_checks.hpp"

#include "solver/formulation/reduce.hpp"

namespace hvi::solver {
namespace {

/// |T||a + b| for the scale of the error, which is not larger, where that is within this part of
/// the tolerance (InteriorEquilibrium).
constexpr double clear_part = 0.1;
/// Tables reach the disk up to the step before a check that waits.
constexpr int longest_wait = 1024; // steps

} // namespace

RowChecks::RowChecks(const InteriorEquilibrium& equilibrium, FieldRecovery& fields,
                     const Plan& plan)
    : equilibrium_(equilibrium), fields_(fields), tolerance_(plan.options.tolerance),
      steps_(static_cast<int>(plan.problem.time.grid.size()) - 1),
      chosen_(checked_steps(plan, steps_)) {}

std::optional<double> RowChecks::error(int n, InteriorEquilibrium::Question question,
                                       const Vector& next) {
  KnownField more[] = {{next, {}}};
  if (waits_) {
    put_off(n, std::move(question));
    if (!settle(more)) return std::nullopt;
    fields_.keep(std::move(more[0]));
    const double error = late_errors_.back().second;
    late_errors_.pop_back();
    return error;
  }
  // By the same sums as many at once: a check that could not wait gives the same bits.
  const InteriorEquilibrium::Question asked[] = {std::move(question)};
  const double error = equilibrium_.errors(asked, clear_part * tolerance_, more).front();
  fields_.keep(std::move(more[0]));
  return error;
}

void RowChecks::put_off(int n, InteriorEquilibrium::Question question) {
  steps_waiting_.push_back(n);
  waiting_.push_back(std::move(question));
}

bool RowChecks::settle_in_time(int n) {
  if (waiting_.empty()) return true;
  const bool full =
      waiting_.size() + 1 == static_cast<std::size_t>(InteriorEquilibrium::most_steps);
  return full || n - steps_waiting_.front() == longest_wait ? settle() : true;
}

/// In one pass. A last step that fails is no late one.
bool RowChecks::settle(std::span<KnownField> more) {
  if (waiting_.empty()) return true;
  const auto errors = equilibrium_.errors(waiting_, clear_part * tolerance_, more);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    late_errors_.emplace_back(steps_waiting_[k], errors[k]);
    if (!(errors[k] <= tolerance_) && steps_waiting_[k] < steps_) return false;
  }
  steps_waiting_.clear(), waiting_.clear();
  return true;
}

} // namespace hvi::solver
