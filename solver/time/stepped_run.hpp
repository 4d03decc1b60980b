// A run whose caller takes its steps one by one, and may look at each: another program that is
// coupled to it, or Python.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/run_settings.hpp"

#include <memory>
#include <string_view>

namespace hvi::solver {

/// The same steps, with the same bits, as run() takes. Writes no files.
class SteppedRun {
public:
  /// `discretisation`, and what `stop` points to, outlive it.
  SteppedRun(const Plan& plan, Discretisation& discretisation,
             const std::atomic<bool>* stop = nullptr);
  SteppedRun(const SteppedRun&) = delete;
  SteppedRun& operator=(const SteppedRun&) = delete;
  ~SteppedRun();

  /// The steps from the next one on are those of this plan, which differs in numbers only
  /// (later_plan.hpp): loads, imposed values, laws, coefficients. The past stays what it was; with
  /// schemes that look back the equation of the next step holds the new plan at its beginning, too.
  /// States then hold all unknowns and imposed values: where they held the contact unknowns only,
  /// or where all imposed values were zero, the steps are taken again, once. Forms and factors that
  /// stay as they are are kept in the discretisation. Throws Failure, and goes on as before then.
  void change(const Plan& plan);
  /// Takes the next step; false: the last one has been taken. A run that has to start again in
  /// another way (run.cpp) does so up to this step. Throws as run() does, and can go no further
  /// then.
  bool advance();
  int step() const { return step_; } ///< the last one that was taken; 0: none
  int steps() const;                 ///< of the plan
  double t() const { return t_; }
  const Vector& u() const { return u_; }   ///< all dofs
  const Vector& xi() const { return xi_; } ///< all rows of laws
  /// A column of the tables at this step; NaN where its own time has not come.
  double value(std::string_view column) const;
  /// What is known after the steps that were taken. Once only; throws Failure(mostly_rounding) as
  /// run() does after the last step.
  RunResult conclude();

private:
  class Tried;

  static Plan as_run(const Plan& plan);

  Plan plan_;
  Discretisation& discretisation_;
  RunSettings settings_;
  std::vector<StepNote> start_notes_; ///< of the problem that it starts from
  std::unique_ptr<Tried> tried_;
  int step_ = 0;
  double t_ = 0.0;
  Vector u_, xi_;
};

} // namespace hvi::solver
