// The certificate on all rows, where steps are solved on the contact unknowns: at some steps, and
// many of them together where nobody sees a step before the last one.
#pragma once

#include "solver/formulation/field_recovery.hpp"
#include "solver/formulation/interior_equilibrium.hpp"
#include "solver/plan/plan.hpp"

#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace hvi::solver {

class RowChecks {
public:
  /// Keeps references to `equilibrium` and `fields`.
  RowChecks(const InteriorEquilibrium& equilibrium, FieldRecovery& fields, const Plan& plan);

  /// Checks may wait for others, up to the last step.
  void let_wait() { waits_ = true; }
  /// Is step n to be checked before it is accepted?
  bool at_once(int n) const { return chosen_[n] != 0 && (!waits_ || n == steps_); }
  /// Is it to be checked later?
  bool later(int n) const { return chosen_[n] != 0 && waits_ && n < steps_; }
  /// The backward error of step n on all rows. The last step makes the checks that were put off,
  /// too; none: one of these failed. `next`: a state whose field is asked for after it.
  [[nodiscard]] std::optional<double> error(int n, InteriorEquilibrium::Question question,
                                            const Vector& next);
  void put_off(int n, InteriorEquilibrium::Question question);
  /// After step n: the checks that wait are made where they are many, or have waited long. False:
  /// one failed.
  [[nodiscard]] bool settle_in_time(int n);
  /// Makes all checks that wait. False: one failed.
  [[nodiscard]] bool settle() { return settle({}); }

  /// All steps up to this one have had their checks; `step`: that of the run.
  int checked_up_to(int step) const {
    return steps_waiting_.empty() ? step : steps_waiting_[0] - 1;
  }
  /// Steps with the errors of checks that were put off; hands each out once.
  std::vector<std::pair<int, double>> late_errors() { return std::exchange(late_errors_, {}); }

private:
  [[nodiscard]] bool settle(std::span<KnownField> more);

  const InteriorEquilibrium& equilibrium_;
  FieldRecovery& fields_;
  double tolerance_;
  int steps_;
  std::vector<char> chosen_; ///< by step
  bool waits_ = false;
  std::vector<int> steps_waiting_;
  std::vector<InteriorEquilibrium::Question> waiting_;
  std::vector<std::pair<int, double>> late_errors_;
};

} // namespace hvi::solver
