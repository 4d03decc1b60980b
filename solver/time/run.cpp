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

#include "solver/time/clock.hpp"
#include "solver/time/report.hpp"
#include "solver/time/step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// Worst numbers over the steps, and the notes.
void note(const StepResult& step, int n, double t, const Plan& plan, RunResult& result) {
  auto& certificate = result.certificate;
  if (std::max(step.equilibrium, step.inclusion.worst) >
      std::max(certificate.equilibrium, certificate.inclusion))
    certificate.worst_step = n;
  certificate.equilibrium = std::max(certificate.equilibrium, step.equilibrium);
  certificate.inclusion = std::max(certificate.inclusion, step.inclusion.worst);
  if (step.inequality.events > 0)
    result.notes.push_back(
        {n, t, fmt::format("{} points released (downward jump)", step.inequality.events),
         plan.law_terms.empty() ? Origin{} : plan.law_terms.front().origin});
}

/// The law term to blame: of the worst point, else the first.
Origin blamed(const StepResult& step, const Plan& plan, const Contact& contact) {
  if (step.inclusion.worst_term >= 0) return plan.law_terms[step.inclusion.worst_term].origin;
  const int worst = step.inequality.worst_point;
  if (worst >= 0 && worst < static_cast<int>(contact.problem.points.size()))
    return plan.law_terms[contact.problem.points[worst].application].origin;
  return plan.law_terms.empty() ? plan.space.origin : plan.law_terms.front().origin;
}

[[noreturn]] void not_certified(const StepResult& step, int n, const Stepper& stepper,
                                const Plan& plan) {
  const auto& grid = stepper.grid();
  const auto place = grid.is_static() ? std::string("the static problem")
                                      : fmt::format("step {} (t = {:.6g})", n, grid.t(n));
  throw Failure(
      FailureKind::not_certified, blamed(step, plan, stepper.contact()),
      fmt::format("no certified solution at {}: equilibrium error {:.2e}, inclusion error "
                  "{:.2e}, tolerance {:.0e}{}{}",
                  place, step.equilibrium, step.inclusion.worst, plan.options.tolerance,
                  step.inequality.verdict.empty() ? "" : "; ", step.inequality.verdict),
      "a smaller step, or a law that softens less, makes the step's problem convex; "
      "`check` prints the step margin");
}

/// Laws that jump down: more than one solution may exist, and the run says which it follows.
void note_choices(const Plan& plan, const Contact& contact, RunResult& result) {
  for (const auto& term : contact.terms) {
    if (term.n_points() == 0) continue;
    const auto& spec = plan.law_terms[term.points.law_term];
    const auto& law = *contact.laws[spec.law];
    if (std::isfinite(
            law.constants(term.points.x[0], plan.time.is_static ? 0.0 : plan.time.grid[0]).m))
      continue;
    result.notes.push_back({0, 0.0,
                            fmt::format("`{}` jumps down, so uniqueness is not guaranteed; {}",
                                        law.spec().name, sentence(plan.options.branch)),
                            spec.origin});
  }
}

class Run {
public:
  Run(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings)
      : plan_(plan), settings_(settings), start_(cpu_seconds()),
        stepper_(plan, discretisation, result_.timing),
        reporter_(plan, discretisation, stepper_, settings) {
    result_.timing.mesh = discretisation.seconds;
    result_.unknowns = stepper_.layout().n_unknowns;
    result_.contact_unknowns = static_cast<int>(stepper_.contact().unknowns.size());
    result_.certificate.tolerance = plan.options.tolerance;
    note_choices(plan, stepper_.contact(), result_);
  }

  void march() {
    const int steps = stepper_.grid().steps();
    for (int n = stepper_.step() + 1; n <= steps; ++n) {
      if (settings_.stop != nullptr && settings_.stop->load())
        throw Failure(FailureKind::interrupted, {}, fmt::format("interrupted before step {}", n));
      step(n);
      record(n == steps);
    }
    result_.certificate.certified = true;
  }

  /// Everything known so far into the result; what tables hold goes to disk.
  RunResult conclude() {
    record(true);
    {
      const PhaseClock clock(result_.timing.output);
      reporter_.finish(result_);
    }
    stepper_.account(result_.work, result_.timing);
    result_.histories = stepper_.memory().reports();
    result_.steps = stepper_.step();
    result_.u = Vector::Zero(stepper_.layout().n_dofs);
    stepper_.layout().scatter(stepper_.u(), result_.u);
    result_.timing.total = cpu_seconds() - start_ + result_.timing.mesh;
    return std::move(result_);
  }

private:
  void step(int n) {
    const PhaseClock clock(result_.timing.steps);
    const auto outcome = stepper_.advance(n);
    if (!outcome.certified) not_certified(outcome, n, stepper_, plan_);
    note(outcome, n, stepper_.t(), plan_, result_);
    if (settings_.progress)
      settings_.progress(
          {n, stepper_.grid().steps(), outcome.inequality.iterations, cpu_seconds() - start_});
  }

  void record(bool last) {
    if (stepper_.step() == 0) return; // nothing certified yet
    const PhaseClock clock(result_.timing.output);
    reporter_.record(stepper_, last);
    if (!settings_.on_step || stepper_.step() == told_) return;
    told_ = stepper_.step();
    Vector full = Vector::Zero(stepper_.layout().n_dofs);
    stepper_.layout().scatter(stepper_.u(), full);
    settings_.on_step(told_, stepper_.t(), full, stepper_.xi());
  }

  const Plan& plan_;
  const RunSettings& settings_;
  double start_;
  int told_ = 0;
  RunResult result_;
  Stepper stepper_;
  Reporter reporter_;
};

} // namespace

namespace {

RunResult run_once(const Plan& plan, const Discretisation& discretisation,
                   const RunSettings& settings, RunResult* partial) {
  Run run(plan, discretisation, settings);
  try {
    run.march();
  } catch (const Failure&) {
    try {
      auto so_far = run.conclude(); // the last good state goes to disk before the failure is told
      if (partial != nullptr) *partial = std::move(so_far);
    } catch (const Failure&) { // the reason to stop comes before a disk that is full as well
    }
    throw;
  }
  return run.conclude();
}

} // namespace hvi::solver
  } catch (const MemoryMistrust&) {
    throw; // nothing that was computed with it is a result
} // namespace

/// A memory that an audit finds outside its tolerance makes the run start again with another route;
/// the direct sum is the last.
RunResult run(const Plan& plan, const Discretisation& discretisation, const RunSettings& settings,
              RunResult* partial) {
  Plan tried = plan;
  std::vector<StepNote> restarts;
  for (;;) {
    try {
      auto result = run_once(tried, discretisation, settings, partial);
      for (const auto& sentence : route_notes(plan, result.histories))
        if (restarts.empty()) result.notes.push_back({0, 0.0, sentence, Origin{}});
      result.notes.insert(result.notes.begin(), restarts.begin(), restarts.end());
      return result;
    } catch (const MemoryMistrust& mistrust) {
      restarts.push_back({0, 0.0, mistrust.said, mistrust.origin});
      tried.histories[mistrust.history].route = mistrust.next;
    }
  }
}

