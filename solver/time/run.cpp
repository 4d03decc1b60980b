// The run: the time loop over certified steps. Pipeline: plan -> discretise -> run -> results.
//
// The fully discrete scheme (paper, Problem "fullydiscrete"): given u_0, for n = 1, ..., N find u_n
// with
//
//   < A (u_n - u_{n-1})/k + B u_n + sum_m E_m (R_m u)_n, v - u_n > + J^0(M u_n; M v - M u_n)
//                                                       >= < f_n, v - u_n >      for all v
//
//   (R_m u)_n = sum_{j <= n} u_j int_{t_{j-1}}^{t_j} q_m(t_n, s) ds
//
// One step is Stepper::advance (step.hpp); this file repeats it, refuses what has no certificate,
// and keeps the last good state when it has to stop.
#include "solver/time/run.hpp"

#include "solver/discrete/discretisation.hpp"
#include "solver/results/trust.hpp"
#include "solver/time/checkpoint.hpp"
#include "solver/time/one_run.hpp"
#include "solver/time/restarts.hpp"
#include "solver/time/start_state.hpp"

#include <optional>
#include <sstream>
#include <utility>
#include <vector>

namespace hvi::solver {
namespace {

/// What is known of a run that has failed is written before the failure is reported, and kept.
std::optional<Restart> conclude_failed(OneRun& run, RunResult* partial) {
  try {
    RunOutcome so_far = run.conclude();
    if (auto* restart = std::get_if<Restart>(&so_far)) return *restart; // a step before has failed
    if (partial != nullptr) *partial = std::get<RunResult>(std::move(so_far));
  } catch (const Failure&) { // the reason to stop comes before a disk that is full as well
  }
  return std::nullopt;
}

RunOutcome run_once(const Plan& plan, const Discretisation& discretisation,
                    const RunSettings& settings, const Restarts& restarts, const std::string* saved,
                    RunResult* partial, Shown* shown) {
  OneRun run(plan, discretisation, settings, restarts, saved, shown);
  try {
    if (const auto restart = run.march()) return *restart;
  } catch (const Failure&) {
    if (const auto restart = conclude_failed(run, partial)) return *restart;
    throw;
  }
  RunOutcome outcome = run.conclude();
  auto* const result = std::get_if<RunResult>(&outcome);
  if (result == nullptr) return outcome;
  try {
    refuse_rounding(*result, plan.problem);
  } catch (const Failure&) {
    result->certificate.certified = false;
    if (partial != nullptr) *partial = std::move(*result);
    throw;
  }
  return outcome;
}

/// A memory that an audit finds outside its tolerance makes the run start again with another route;
/// the direct sum is the last. One that was made for an earlier end and cannot go on beyond it
/// makes the run start again for the later one.
RunResult run_all(const Plan& plan, const Discretisation& discretisation,
                  const RunSettings& settings, RunResult* partial, Shown* shown) {
  if (plan.start) {
    std::vector<StepNote> notes;
    const Plan begun = with_start_solved(plan, discretisation, settings, notes);
    RunResult result = run_all(begun, discretisation, settings, partial, shown);
    result.notes.insert(result.notes.begin(), notes.begin(), notes.end());
    return result;
  }
  Restarts restarts;
  restarts.routes.assign(plan.problem.histories.size(), -1);
  std::optional<std::string> saved = saved_state(plan, discretisation, settings);
  if (saved) {
    std::istringstream in(*saved);
    StateReader r(in, {});
    with_its_name(checkpoint_path(settings.output_folder, settings.name),
                  [&] { restarts.restore(r, plan); });
  }
  for (;;) {
    const Plan tried = restarts.applied(plan);
    RunOutcome outcome = run_once(tried, discretisation, settings, restarts,
                                  saved ? &*saved : nullptr, partial, shown);
    if (const auto* restart = std::get_if<Restart>(&outcome)) {
      restarts.take(*restart, saved.has_value());
      if (!std::holds_alternative<LateCheck>(*restart)) saved.reset();
      if (settings.on_restart) settings.on_restart();
      continue;
    }
    auto result = std::get<RunResult>(std::move(outcome));
    restarts.add_notes(plan, result);
    return result;
  }
}

} // namespace

RunResult run(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings,
              RunResult* partial) {
  return run_all(plan, discretisation, settings, partial, nullptr);
}

RunResult run_shown(const Plan& plan, const Discretisation& discretisation,
                    const RunSettings& settings, Shown& shown, RunResult* partial) {
  return run_all(plan, discretisation, settings, partial, &shown);
}

} // namespace hvi::solver
