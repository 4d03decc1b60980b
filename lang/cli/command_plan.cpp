// hvi-run plan: what would be done, from the first steps.
#include "lang/cli/commands.hpp"
#include "lang/cli/interrupt.hpp"
#include "lang/cli/memory_lines.hpp"
#include "lang/cli/outputs.hpp"
#include "lang/cli/say.hpp"
#include "lang/forecast.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/discrete/memory.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

namespace {

constexpr double long_wait = 5.0; ///< seconds from which it pays to change what BLAS does

void print_forecast(const Forecast& f) {
  const auto& r = f.result;
  const auto& w = r.work;
  const std::string evolution = r.path.empty()
                                    ? "contact unknowns: all tensors are multiples of one tensor"
                                    : "all unknowns: " + r.path;
  say("evolution on {}\n", evolution);
  print_solver(r.solver);
  say("{} unknowns, {} of them in contact laws; {} {}, {} analys{}, {} factorisation{}{}\n",
      r.unknowns, r.contact_unknowns, w.matrices, w.matrices == 1 ? "matrix" : "matrices",
      w.analyses, w.analyses == 1 ? "is" : "es", w.factorisations, w.factorisations == 1 ? "" : "s",
      w.singles ? " in single precision" : "");
  const double per_step = f.taken > 0 ? 1.0 / f.taken : 0.0;
  say("a step: {:.3g} triangular solves, {:.3g} products, {:.3g} Newton iterations; {:.3g} MB "
      "held\n",
      w.triangular_solves * per_step, w.products * per_step, w.newton * per_step, w.bytes / 1e6);
  const std::string rehearsed =
      f.memory.rehearsed > 0 ? fmt::format("; {} of its memory alone", f.memory.rehearsed) : "";
  say("predicted: {:.3g} s for {} step{}, without files (from the first {}{})\n", f.seconds(),
      f.steps, f.steps == 1 ? "" : "s", f.taken, rehearsed);
  if (r.solver.solver == solver::LinearSolver::direct && f.seconds() > long_wait)
    say("{}", advice_on_kernels());
  const auto room = solver::memory_room();
  const double more = f.most_bytes - solver::memory_held();
  say("memory: {} at most{}\n", solver::bytes_text(f.most_bytes),
      more > room.bytes ? fmt::format(", MORE than {} leaves", room.from) : "");
  if (w.iterative.assembling > 1)
    say("assembly: each of the {} processes on its own cells\n", w.iterative.assembling);
  if (w.iterative.bytes_of_others > 0)
    say("memory of each other process: {} at most\n",
        solver::bytes_text(w.iterative.bytes_of_others));
}

std::string count(std::size_t number, const char* what) {
  return fmt::format("{} {}{}", number, what, number == 1 ? "" : "s");
}

/// The effects as declared, or with what the first steps showed of them.
void print_effects(const Script& script, const std::optional<Forecast>& first_steps) {
  using State = solver::EffectNote::State;
  const bool ran = first_steps && !first_steps->result.effects.empty();
  for (const solver::EffectNote& note :
       ran ? first_steps->result.effects : script.plan->problem.effects) {
    const char* state = note.state == State::on        ? "on"
                        : note.state == State::off     ? "off"
                        : note.state == State::dropped ? "dropped"
                                                       : "asleep";
    const int line = line_of(script, note.origin);
    std::string why = note.why.empty() ? "" : ": " + note.why;
    const bool may_change = note.state == State::asleep || note.why.starts_with("linear");
    if (ran && may_change && first_steps->taken < first_steps->steps)
      why += fmt::format(" up to step {}", first_steps->taken);
    say("{:<8} {}{}{}\n", state, note.name, line > 0 ? fmt::format(", line {}", line) : "", why);
  }
}

} // namespace

int plan_command(const std::string& path, const Options& options) {
  HeldOutputs outputs;
  Session session(path, compile_settings(options));
  Script& script = session.script;
  std::vector<solver::HistoryReport> memory;
  Exit code = session.compile();
  if (code == exit_ok) code = outputs.take(outputs_in("", {}, options), options, session);
  if (code == exit_ok)
    code = session.attempt([&] { memory = solver::planned_memory(*script.plan); });
  if (code != exit_ok) {
    show_diagnostics(script, options);
    return code;
  }
  std::optional<Forecast> first_steps;
  code = session.discretise(&stop_flag());
  if (code == exit_ok)
    code = session.attempt([&] { first_steps = forecast(*script.plan, session.discretisation); });
  if (!json_only(options)) {
    print_effects(script, first_steps);
    print_memory(script.plan->problem, memory);
    say("{}, {}, {}, {}\n", count(script.plan->problem.forms.size(), "form"),
        count(script.plan->problem.histories.size(), "memory field"),
        count(script.plan->problem.law_terms.size(), "law"),
        count(script.plan->problem.loads.size() + script.plan->problem.state_loads.size(), "load"));
    if (first_steps) print_forecast(*first_steps);
  }
  if (first_steps && code == exit_ok)
    code =
        session.attempt([&] { write_json(options, forecast_json(script, *first_steps, memory)); });
  show_diagnostics(script, options);
  return code;
}

} // namespace hvi::lang
