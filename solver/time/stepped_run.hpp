// A run whose caller takes its steps one by one, and may look at each: another program that is
// coupled to it, or Python.
#pragma once

#include "solver/time/run.hpp"

#include <memory>
#include <string_view>

namespace hvi::solver {

/// The same steps, with the same bits, as run() takes. Writes no files.
class SteppedRun {
public:
  /// `discretisation`, and what `stop` points to, outlive it.
  SteppedRun(const Plan& plan, const Discretisation& discretisation,
             const std::atomic<bool>* stop = nullptr);
  SteppedRun(const SteppedRun&) = delete;
  SteppedRun& operator=(const SteppedRun&) = delete;
  ~SteppedRun();

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

  Plan plan_;
  const Discretisation& discretisation_;
  RunSettings settings_;
  std::vector<StepNote> start_notes_; ///< of the problem that it starts from
  std::unique_ptr<Tried> tried_;
  int step_ = 0;
  double t_ = 0.0;
  Vector u_, xi_;
};

} // namespace hvi::solver
