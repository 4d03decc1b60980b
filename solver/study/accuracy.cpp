// The search for a wanted accuracy: its course, the runs and their check; see accuracy.hpp.
#include "solver/study/accuracy.hpp"

#include "solver/common/clock.hpp"
#include "solver/study/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int most_tries = 12;
constexpr double margin = 1.2; ///< a setting is chosen for so much less than the check asks
/// Times are not looked for in parts of the data that are smaller than this times the wanted error,
/// relative to the others.
constexpr double negligible = 0.01;

/// Memories are computed to a thousandth of the wanted error.
Plan prepared(const Plan& plan, const AccuracyRequest& request) {
  Plan out = plan;
  out.options.memory_tolerance = std::clamp(1e-3 * request.wanted, 1e-10, 1e-5);
  return out;
}

} // namespace

Search::Search(const Plan& plan, const AccuracyRequest& request, const RunSettings& settings,
               const std::function<void(const std::string&)>& tell, Shown* shown)
    : family_(prepared(plan, request)), runner_(family_, settings, shown), tell_(tell),
      space_distance_(request.probe.empty() && plan.problem.space.more.empty()
                          ? Distance::orthogonal
                          : Distance::additive) {
  out_.request = request;
  out_.memory_tolerance = family_.plan().options.memory_tolerance;
  floor_ = std::max(1e-3 * request.wanted, 1e-11);
  family_.follow_data(negligible * request.wanted);
}

AccuracyResult Search::go() {
  const double start = cpu_seconds();
  target_ = out_.request.wanted / (accuracy_safety * margin);
  choose_candidates();
  for (int k = 0; k < most_tries && !out_.reached; ++k) attempt(choose());
  out_.cpu = cpu_seconds() - start;
  out_.spared = runner_.spared();
  if (!out_.reached)
    give_up(out_.tries.empty()
                ? "the errors seen do not fall as coarser runs promised"
                : fmt::format("after {} settings the estimated error is still {:.2e}",
                              out_.tries.size(), out_.tries.back().estimate));
  return std::move(out_);
}

void Search::give_up(const std::string& why) {
  const std::string what = !out_.request.probe.empty() ? "of `" + out_.request.probe + "`"
                           : family_.plan().problem.space.more.empty() ? "of u in V"
                                                                       : "of all unknowns together";
  throw AccuracyFailure(fmt::format("a relative error {} of {:.1e} is out of reach: {}", what,
                                    out_.request.wanted, why),
                        std::move(out_));
}

void Search::attempt(const Choice& choice) {
  const auto& s = choice.setting;
  AccuracyTry now;
  now.setting = s;
  now.text = to_string(s, family_.at(s).problem);
  now.predicted_error = choice.error;
  now.steps = s.steps;
  tell_(fmt::format("chosen: {}; about {:.0f} unknowns, predicted error {:.1e}, {:.2g} CPU "
                    "seconds with its check",
                    now.text, choice.unknowns, choice.error, choice.seconds));
  Setting half = s;
  half.level /= 2;
  const KeptRun& companion = cheap(half, "companion of half the level");
  if (!companion.failure.empty() || !look_at_time(now, half, companion)) {
    // What is chosen must be well inside what can be certified.
    target_ *= 0.5;
    return;
  }
  const ErrorLaw space = space_law(element_of(s));
  if (accuracy_safety * (now.time_error + space.at(s.level)) > out_.request.wanted) {
    tell_(fmt::format("the steps are too few: error in time {:.1e}", now.time_error));
    tighten(s);
    return;
  }
  now.predicted_cpu = predicted_seconds(s, companion);
  tell_(fmt::format("running {}: about {:.2g} CPU seconds", now.text, now.predicted_cpu));
  finish(now, runner_.final_run(s), companion);
}

/// Set-up from the run whose unknowns are nearest; steps from the two companions, whose
/// difference is what a step costs and whose rest is what the first step does once.
double Search::predicted_seconds(const Setting& setting, const KeptRun& companion) {
  const auto& points = costs_.at(kind_of(setting));
  const double unknowns = companion.cost.unknowns * std::pow(2.0, family_.dim());
  CostLaw law = fit_cost(points, family_.dim());
  law.at = companion.cost;
  const auto off = [&](const CostPoint& p) { return std::abs(std::log(p.unknowns / unknowns)); };
  for (const CostPoint& p : points)
    if (off(p) < 0.8 * off(law.at)) law.at = p;
  const double setup = law.seconds(unknowns, 0.0), steps = std::max(1, setting.steps);
  double each = companion.cost.step, once = 0.0;
  if (!family_.is_static()) {
    Setting fewer = companion.setting;
    fewer.steps /= 2;
    const double all = each * steps, half = runner_.cheap(fewer).cost.step * fewer.steps;
    each = std::clamp((all - half) / (steps - fewer.steps), 0.3 * each, each);
    once = all - each * steps;
  }
  const double more = unknowns / companion.cost.unknowns;
  int every = static_cast<int>(steps);
  for (const auto& table : family_.at(setting).report.tables) every = std::min(every, table.every);
  return setup + (once + each * steps) * std::pow(more, law.step_power) +
         companion.row * more * steps / every;
}

void Search::finish(AccuracyTry& now, const KeptRun& run, const KeptRun& companion) {
  now.cpu = run.result.timing.total;
  now.unknowns = run.result.unknowns;
  costs_[kind_of(now.setting)].push_back(run.cost);
  now.space_distance = distance_between(companion, run);
  record_distance(companion, run, now.space_distance);
  add_rung(space_[element_of(now.setting)], {0.5 * now.setting.level, 2.0, now.space_distance});
  const ErrorLaw law = space_law(element_of(now.setting));
  now.space_order = law.order;
  now.space_error = finer_error(now.space_distance, 2.0, now.space_order, space_distance_);
  if (space_distance_ == Distance::additive)
    now.space_error = std::max(now.space_error, law.at(now.setting.level));
  now.estimate = now.space_error + now.time_error;
  out_.tries.push_back(now);
  out_.reached = accuracy_safety * now.estimate <= out_.request.wanted;
  out_.run = run.result;
  out_.plan = run.plan;
  out_.discretisation = run.discretisation;
  tell_(fmt::format("estimated error {:.2e} (space {:.1e}, time {:.1e}), times {} {} the wanted "
                    "{:.1e}",
                    now.estimate, now.space_error, now.time_error, accuracy_safety,
                    out_.reached ? "within" : "above", out_.request.wanted));
  if (out_.reached) return;
  // Two runs of a ladder may be near each other by chance, where an error changes its sign.
  refused_[element_of(now.setting)] = {static_cast<double>(now.setting.level), now.space_error};
  tighten(now.setting);
}

/// After a setting whose check failed: the laws are fitted again with its runs; where they would
/// choose the same setting, the aim is lowered.
void Search::tighten(const Setting& refused) {
  for (int k = 0; k < 40; ++k, target_ *= 0.85) {
    const auto again = cheapest(candidates(), family_, target_, out_.request.most_unknowns,
                                out_.request.most_steps);
    if (!again || again->setting != refused) return;
  }
}

AccuracyResult reach_accuracy(const Plan& plan, const AccuracyRequest& request,
                              const RunSettings& settings,
                              const std::function<void(const std::string&)>& tell, Shown* shown) {
  return Search(plan, request, settings, tell, shown).go();
}

} // namespace hvi::solver
