// A run as it is tried once: all steps from the first, or from a saved state, to the last, unless
// it has to start again. Used by run.cpp and stepped_run.cpp.
#pragma once

#include "solver/common/clock.hpp"
#include "solver/discrete/chosen_solver.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/shared_work.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/energy.hpp"
#include "solver/results/report.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/run_settings.hpp"
#include "solver/step/step.hpp"
#include "solver/step/work.hpp"
#include "solver/time/restarts.hpp"

namespace hvi::solver {

/// A result, or why the run has to start again.
using RunOutcome = std::variant<RunResult, Restart>;

class OneRun {
public:
  /// `plan`, `restarts` and `settings` outlive it. `saved`: a state to go on from, or null.
  /// `shown`: null where nothing is.
  OneRun(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings,
         const Restarts& restarts, const std::string* saved, Shown* shown = nullptr);
  OneRun(const OneRun&) = delete; // its parts refer to each other
  OneRun& operator=(const OneRun&) = delete;

  /// All steps. Set: the run has to start again.
  std::optional<Restart> march();
  /// The next one of them. Throws Failure(not_certified) where it has no certificate, and what
  /// RunSettings::stop asks for.
  std::optional<Restart> take_step(LapClock<>& clock);
  bool at_end() const;
  int step() const { return state_.evolution.step(); } ///< the last one that was taken
  /// All steps have been taken, each with its certificate.
  void certify() { result_.certificate.certified = true; }
  int steps() const { return state_.evolution.grid().steps(); }
  const ChosenSolver& solver() const { return result_.solver; }
  /// The probes at the last recorded step; NaN where the time of one has not come.
  std::span<const double> values() const { return reporter_.values(); }
  /// Do states hold the contact unknowns only?
  bool reduced() const { return state_.formulation->reduced(); }
  /// Do they hold imposed values?
  bool imposed() const { return state_.formulation->imposed(); }
  /// Writes the accepted state, with all that it remembers, and what has been found so far.
  void hand_over(std::ostream& out) const;
  /// In the place of a run of another plan, which wrote this, before any step: the same unknowns at
  /// the same times, with memories of the same kernels. Set: a memory cannot go on.
  std::optional<HorizonEnd> take_over(std::istream& in);
  /// The plan has other loads than before.
  void take_loads();
  /// Puts everything known so far into the result and writes the tables, unless a check that was
  /// put off fails.
  RunOutcome conclude();

private:
  Spared spared() const;
  std::optional<Restart> step(int n);
  /// All steps up to this one have had their checks.
  int checked_up_to();
  /// Of checks that were put off.
  void note_late_errors();
  void begin();
  void record(bool last);
  /// What rounding may have done to the columns.
  void estimate_forward_error();
  /// Of several unknowns: parts of how far the forces in its rows would move each of them, which
  /// may cancel (a fluid at rest under its pressure).
  ByUnknown nothing_of_each(const StepMatrix* matrix) const;
  /// A part of the multipliers that would hold the forces in their rows, which may cancel (a side
  /// along which a body moves).
  double nothing_of_multipliers(const StepMatrix* matrix) const;
  /// Vector laws have no equilibrium curve (point_curve.hpp).
  bool branches_are_followed() const;
  /// Where several solutions are possible: that it is so, which branch this is, and its energy.
  void tell_choice();
  void finish_monitors();
  void account(WorkCounters& work, Timing& timing) const;
  void go_on(const std::string& saved);
  bool checkpoint(); ///< is it written?
  [[noreturn]] void stop_before(int step);
  void stop_within_step() const;
  /// Set: a memory cannot go on from there.
  std::optional<HorizonEnd> restore(std::istream& in);
  /// Rows of tables, the certificate, notes and counters.
  void save_findings(std::ostream& out) const;
  void restore_findings(std::istream& in);

  const Plan& plan_;
  const Restarts& restarts_;
  const Discretisation& discretisation_;
  const RunSettings& settings_;
  double start_;
  Spared spared_;                   ///< by earlier runs' work, when this one began
  std::optional<HorizonEnd> ended_; ///< set: the saved state cannot be gone on from
  int told_ = 0;
  bool concludes_ = false; ///< what is known is put together: its solves are not interrupted
  int saved_ = 0;          ///< the step whose state is in the checkpoint; 0: there is none
  RunResult result_;
  Stepper stepper_;
  const RunState& state_; ///< of the stepper
  Reporter reporter_;
  std::optional<EnergyMonitor> monitor_;
  std::vector<double> monitor_times_;
  std::uint64_t fingerprint_ = 0;
  std::array<int, 9> grown_before_{};
};

} // namespace hvi::solver
