// One step of the fully discrete scheme: how the state of a run advances.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/run_state.hpp"
#include "solver/step/work.hpp"

#include <functional>
#include <utility>

namespace hvi::solver {

/// Asked at the first step, for all of them.
struct UniquenessVerdict {
  std::string obstacle; ///< why not every step is sure to have one solution (uniqueness.hpp)
  bool judged = false;  ///< not yet: it is that of the run this one goes on from
};

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

  /// Called before every iteration of a step, and between those of linear systems. What it throws
  /// ends the step in the middle, and then this stepper takes no other.
  void call_before_iterations(std::function<void()> what) {
    state_.solver.equations.matrices.call_before_iterations(std::move(what));
  }

  /// Step n (1 .. steps). Without a certificate, or with a reason to start again, the state stays
  /// at step n - 1. Throws Failure(not_coercive).
  StepResult advance(int n);

  const RunState& state() const { return state_; }
  /// Why not every step is sure to have one solution; empty: each has.
  const std::string& not_unique() const { return uniqueness_.obstacle; }
  /// Adds what was counted to the counters and phases of a run.
  void account(WorkCounters& work, Timing& timing) const;

  void save(std::ostream& out) const;
  /// Set: a memory cannot go on from there, and what was read is not to be used.
  std::optional<HorizonEnd> restore(std::istream& in);
  /// Of these what does not depend on the matrices and laws of the plan (hand_over.cpp).
  void hand_over(std::ostream& out) const;
  std::optional<HorizonEnd> take_over(std::istream& in);
  /// The plan has other loads than before.
  void take_loads(const Discretisation& discretisation);

private:
  StepResult attempt(int n, StepMatrix& matrix);
  [[nodiscard]] bool accept(int n, StepMatrix& matrix, const StepResult& result);

  const Plan& plan_;
  const Discretisation& discretisation_;
  Timing& timing_;
  RunState state_;
  WorkCounters counted_;
  UniquenessVerdict uniqueness_;
};

/// Are branches followed where steps may have several solutions, for this reason?
bool follows_branches(const std::string& not_unique, const Contact& contact);

} // namespace hvi::solver
