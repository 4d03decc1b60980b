// One step of the fully discrete scheme: the state of a run and how it advances.
#pragma once

#include "solver/common/clock.hpp"
#include "solver/time/rounding_estimate.hpp"
#include "solver/time/step_solver.hpp"

#include <utility>

namespace hvi::solver {

/// Advances u_{n-1} to u_n:  find d = u_n - u_{n-1} and xi with
///
///   K d + G^T W xi = f_n - B u_{n-1} - sum_m E_m (w0_m u_{n-1} + h_m) + A carry d_{n-1},
///   K = rate A + B + sum_m w0_m E_m,      xi_p in dj_p((G u_n)_p + offset_p(t_n))
///
/// (paper, Problem "fullydiscrete", its equation divided by the step and written for the increment:
/// no A u_{n-1} / k, so nothing cancels when the step is small). Static: the same with u_{-1} = 0.
class Stepper {
public:
  Stepper(const Plan& plan, const Discretisation& discretisation, Timing& timing);

  /// Step n (1 .. steps). Without a certificate, or with a reason to start again, the state stays
  /// at step n - 1. Throws Failure(not_coercive).
  StepResult advance(int n);

  /// Checks on all rows may be made together, up to the last step: for runs of which nothing is
  /// seen before that.
  void let_checks_wait();
  /// Makes the checks that were put off. False: one failed.
  [[nodiscard]] bool make_checks();
  /// All steps up to this one have had their checks.
  int checked_up_to() const;
  /// Steps with the errors of checks that were put off; hands each out once.
  std::vector<std::pair<int, double>> late_errors();

  const Formulation& formulation() const { return *formulation_; }
  const Evolution& evolution() const { return evolution_; }
  const Balance& balance() const { return balance_; }
  const StepSolver& solver() const { return solver_; }
  const Contact& contact() const { return formulation().contact(); }
  const TimeGrid& grid() const { return evolution_.grid(); }
  int step() const { return evolution_.step(); }
  double t() const { return evolution_.t(); }
  const Vector& u() const { return evolution_.u(); }
  const Vector& xi() const { return solver_.laws().xi; }
  const Vector& arguments() const { return trial_.z; } ///< of the laws, at the last attempted step
  /// Results may read these dofs in every step.
  void observe(std::span<const int> dofs) { formulation_->observe(dofs); }
  /// Why not every step is sure to have one solution; empty: each has (uniqueness.hpp). Found at
  /// the first step, for all of them.
  const std::string& not_unique() const { return not_unique_; }
  const RoundingEstimate& rounding() const { return rounding_; }
  /// RoundingEstimate::samples, after the last step.
  std::vector<ErrorSample> rounding_errors(double backward_error);
  /// The condition number of the last step's matrix in the 1-norm, estimated; 0: not known.
  double condition() const { return formulation_->condition(solver_.matrices().latest()); }
  /// Adds what was counted to the counters and phases of a run.
  void account(WorkCounters& work, Timing& timing) const;

  void save(std::ostream& out) const;
  void restore(std::istream& in);

private:
  Stepper(const Plan& plan, const Discretisation& discretisation, Timing& timing,
          const PhaseClock<>& clock);
  void judge_uniqueness(StepMatrix& matrix);
  bool follows() const;
  StepResult attempt(int n, StepMatrix& matrix);
  void count(const StepResult& result);
  [[nodiscard]] bool accept(int n, StepMatrix& matrix, const StepResult& result);

  const Plan& plan_;
  Timing& timing_;
  std::unique_ptr<Formulation> formulation_;
  Evolution evolution_;
  Balance balance_;
  StepSolver solver_;
  RoundingEstimate rounding_;
  std::unique_ptr<RowChecks> checks_; ///< null: every step is checked on all rows
  StepEquation equation_;             ///< of the last attempted step
  Trial trial_;
  WorkCounters counted_;
  std::string not_unique_;
  bool uniqueness_judged_ = false;
};

} // namespace hvi::solver
