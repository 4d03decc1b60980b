// See forecast.hpp.
#include "lang/forecast.hpp"

#include "solver/common/memory_room.hpp"
#include "solver/discrete/memory.hpp"
#include "solver/linear/bandwidth.hpp"
#include "solver/results/result_json.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace hvi::lang {

double Forecast::history() const {
  const auto& r = result;
  const double bytes = sizeof(double) * (r.path.empty() ? r.contact_unknowns : r.unknowns);
  return memory.reads > 0.0 || memory.seconds > 0.0
             ? memory.seconds + memory.reads * bytes / solver::read_bandwidth()
             : 0.0;
}

double Forecast::seconds() const {
  if (taken >= steps) return result.timing.mesh + last;
  // In the first steps everything sticks; those with slip cost about half as much again. Iterations
  // differ from step to step: the mean of all but the first, which sets the multigrid up.
  const bool iterative = result.solver.solver == solver::LinearSolver::iterative;
  const double of_each = iterative && taken > 1 ? (last - first) / (taken - 1) : each;
  const double later = friction ? 1.5 * of_each : of_each;
  return result.timing.mesh + last + later * (steps - taken) + history();
}

Forecast forecast(const solver::Plan& plan, const solver::Discretisation& discretisation,
                  const std::atomic<bool>* interrupted) {
  Forecast out;
  out.friction = std::any_of(plan.problem.laws.begin(), plan.problem.laws.end(),
                             [](const solver::LawSpec& law) { return law.radial; });
  std::atomic<bool> stop = false;
  solver::RunSettings settings;
  settings.stop = &stop;
  settings.progress = [&](const solver::Progress& p) {
    if (p.step > 1) out.each = std::min(out.each, p.seconds - out.last);
    if (p.step == 1) out.first = p.seconds;
    out.last = p.seconds, out.taken = p.step, out.steps = p.steps;
    const bool asked = interrupted != nullptr && interrupted->load();
    stop = asked || p.step >= std::clamp(p.steps / 50, 8, 24);
  };
  try {
    out.result = solver::run(plan, discretisation, settings, &out.result);
  } catch (const solver::Failure& failure) {
    const bool asked = interrupted != nullptr && interrupted->load();
    if (asked || failure.kind != solver::FailureKind::interrupted) throw;
  }
  const auto& r = out.result;
  out.most_bytes = solver::memory_peak() +
                   solver::history_bytes_to_come(plan, r.histories,
                                                 r.path.empty() ? r.contact_unknowns : r.unknowns);
  if (out.taken < out.steps) out.memory = solver::rehearse_memory(plan, out.taken);
  return out;
}

nlohmann::ordered_json forecast_json(const Script& script, const Forecast& forecast,
                                     const std::vector<solver::HistoryReport>& memory) {
  solver::RunResult first_steps = forecast.result;
  first_steps.script = script.path;
  first_steps.histories = memory;
  return solver::plan_json(
      first_steps, script.plan->problem, json_context(script),
      {forecast.steps, forecast.taken, forecast.seconds(), forecast.most_bytes});
}

} // namespace hvi::lang
