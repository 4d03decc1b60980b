// hvi-run run, test and plan: solving, judging expectations, saying what would be done.
#include "lang/accuracy_report.hpp"
#include "lang/check_report.hpp"
#include "lang/driver.hpp"
#include "lang/interrupt.hpp"
#include "lang/memory_lines.hpp"
#include "lang/mesh_values.hpp"
#include "lang/pictures.hpp"
#include "solver/linear/bandwidth.hpp"
#include "solver/output/file.hpp"
#include "solver/output/table.hpp"
#include "solver/time/checkpoint.hpp"
#include "solver/time/memory.hpp"
#include "solver/time/rehearsal.hpp"
#include "solver/time/report.hpp"
#include "solver/time/result_json.hpp"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

namespace hvi::lang {

namespace {

/// One line on the terminal, rewritten at most ten times a second.
class ProgressLine {
public:
  explicit ProgressLine(bool enabled) : enabled_(enabled && isatty(STDERR_FILENO)) {}
  bool enabled() const { return enabled_; }
  void operator()(const solver::Progress& p) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(100) && p.step != p.steps) return;
    last_ = now;
    const double wall = std::chrono::duration<double>(now - start_).count();
    fmt::print(stderr, "\r\033[Kstep {}/{}  {} Newton  {:.0f} s left", p.step, p.steps, p.newton,
               wall * (p.steps - p.step) / p.step);
    if (p.step == p.steps) fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
  }

private:
  bool enabled_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_{};
};

/// Mesh and parts; every mistake becomes a diagnostic. False when there are any.
bool discretise_script(Script& script, solver::Discretisation& out) {
  try {
    for (const solver::Failure& failure : solver::discretise(*script.plan, out, &stop_flag()))
      add_failure(script, failure);
    if (!script.diagnostics.has_errors()) check_materials(script, out);
  } catch (const solver::Failure& failure) {
    add_failure(script, failure);
  }
  return !script.diagnostics.has_errors();
}

solver::ReportTable table_of(const solver::RunResult& result) {
  solver::ReportTable table;
  table.names.push_back("t");
  table.columns.push_back(result.times);
  const bool with_events = solver::shows_events(result);
  for (const std::string& name : result.column_order) {
    table.names.push_back(name);
    table.columns.push_back(result.columns.at(name));
  }
  if (with_events) {
    table.names.emplace_back(solver::event_column);
    table.columns.emplace_back(result.events.begin(), result.events.end());
  }
  return table;
}

/// The last values of the energies, and the quantities of Lemma 3.2.
void print_monitors(const solver::MonitorTable& m) {
  if (m.times.empty()) return;
  const auto last = [&](const char* name) {
    const auto at = std::find(m.names.begin(), m.names.end(), name) - m.names.begin();
    return m.columns[static_cast<std::size_t>(at)].back();
  };
  fmt::print("energy: {:.9g} = elastic {:.9g} + contact {:.9g} - load\n", last("energy"),
             last("elastic"), last("contact"));
  fmt::print("work: {:.9g}; viscous {:.6g}, memory {:.6g}, lost {:.6g} (balance to {:.1e})\n",
             last("work"), last("viscous"), last("memory"), last("lost"), m.balance_error);
  fmt::print("lemma 3.2: max|u| {:.6g}, sum|du|^2 {:.6g}, max|xi| {:.6g}, sum k|du/k|^2 {:.6g}\n",
             last("lemma_u"), last("lemma_jumps"), last("lemma_xi"), last("lemma_rate"));
}

/// One line, where rounding shows in the digits that are printed.
void print_forward_error(const solver::ForwardError& error) {
  const double worst = error.worst();
  if (worst <= solver::ForwardError::small && !error.refined) return;
  std::string of = "the solution";
  for (const auto& column : error.columns)
    if (column.relative >= worst) of = "`" + column.name + "`";
  const std::string condition =
      error.condition > 0.0 ? fmt::format(", condition number about {:.1e}", error.condition) : "";
  fmt::print("rounding: changes {} by about {:.1e} of its size{}{}\n", of, worst, condition,
             error.refined ? ", steps refined in extended precision" : "");
}

void print_certificate(const solver::RunResult& r, const Script& script) {
  const solver::Certificate& c = r.certificate;
  if (c.certified)
    fmt::print("certified: {}, worst inclusion {:.1e} at step {}, worst equilibrium {:.1e} at step "
               "{}, tolerance {:.0e}\n",
               r.steps == 1 ? "1 step" : fmt::format("all {} steps", r.steps), c.inclusion,
               c.inclusion_step, c.equilibrium, c.equilibrium_step, c.tolerance);
  print_forward_error(r.forward_error);
  if (r.work.followed_steps > 0)
    fmt::print("{} steps followed their branch by {} inner steps\n", r.work.followed_steps,
               r.work.inner_steps);
  if (r.work.unfollowed_steps > 0)
    fmt::print(
        "note: {} steps may have left their branch: it was not followed (a vector law, more "
        "than 1200 points, forms without symmetry, bounds found together with their laws, or a "
        "curve without a further stable state); their answers may depend on the number of steps\n",
        r.work.unfollowed_steps);
  if (r.work.fallback_steps > 0)
    fmt::print("steps that only the globally convergent method solved: {}\n",
               r.work.fallback_steps);
  if (r.monitors) print_monitors(*r.monitors);
  print_memory(*script.plan, r.histories);
  for (const solver::StepNote& note : r.notes) {
    const int line = line_of(script, note.origin);
    const std::string when =
        note.step > 0 ? fmt::format("step {} (t = {:.6g}): ", note.step, note.t) : std::string();
    fmt::print("note: {}{}{}\n", when, note.what, line > 0 ? fmt::format(" (line {})", line) : "");
  }
  if (r.energy) fmt::print("energy of this branch at the end: {:.9g}\n", *r.energy);
}

constexpr double long_run = 0.2; ///< CPU seconds from which the JSON has the measured bandwidth

/// Phases, what was counted, and the limit of the sweeps: one read of the factor each.
void print_profile(const solver::RunResult& r, double bandwidth) {
  const auto& t = r.timing;
  const double steps = std::max(1, r.steps);
  const double rest = t.total - t.mesh - t.assembly - t.ordering - t.factor - t.steps - t.output;
  fmt::print(stderr, "{:<24}{:>12}{:>14}{:>20}\n", "profile", "CPU seconds", "ms per step",
             "ms, the limit");
  const auto line = [&](const char* name, double seconds, bool each, double limit = 0.0) {
    fmt::print(stderr, "{:<24}{:>12.4f}{:>14}{:>20}\n", name, seconds,
               each ? fmt::format("{:.4f}", 1e3 * seconds / steps) : "",
               limit > 0.0 ? fmt::format("{:.4f}", 1e3 * limit / steps) : "");
  };
  line("mesh", t.mesh, false), line("assembly", t.assembly, false);
  line("ordering", t.ordering, false), line("factorisation", t.factor, false);
  line("steps", t.steps, true), line("  history", t.history, true);
  line("  sweeps", t.sweeps, true, t.swept_bytes / bandwidth),
      line("  inequality", t.inequality, true);
  line("output", t.output, true), line("set-up besides", std::max(0.0, rest), false);
  line("total", t.total, false);
  const auto& w = r.work;
  fmt::print(stderr,
             "counted: {} unknowns, {} steps, {} matrices, {} analyses, {} factorisations, {} "
             "sweeps, {} products, {} Newton, {} fields read {} times\n",
             r.unknowns, r.steps, w.matrices, w.analyses, w.factorisations, w.sweeps, w.products,
             w.newton, w.history_fields, w.field_reads);
  fmt::print(stderr,
             "the limit: every sweep reads its factor once, {:.3g} MB in all, at the {:.3g} GB/s "
             "measured on this machine\nheld: {:.3g} MB (factors, matrices, memory)\n",
             t.swept_bytes / 1e6, bandwidth / 1e9, w.bytes / 1e6);
}

void write_json(const Script& script, const solver::RunResult& result, const Options& options,
                const std::optional<solver::AccuracyResult>& accuracy, double bandwidth) {
  if (options.json.empty()) return;
  solver::ResultContext context;
  for (const ModelParam& p : script.model->params)
    if (const auto* v = std::get_if<double>(&p.value)) context.params[p.name] = *v;
  context.bandwidth = bandwidth;
  context.line_of = [&](solver::Origin origin) { return line_of(script, origin); };
  std::string text = solver::result_json(result, *script.plan, context);
  if (accuracy) text = with_accuracy(text, *accuracy);
  solver::write_atomically(options.json, text);
}

std::optional<double> value_at(const solver::RunResult& result, const Expectation& e) {
  if (!e.time) {
    auto found = result.final.find(e.probe);
    return found == result.final.end() ? std::nullopt : std::optional(found->second);
  }
  auto column = result.columns.find(e.probe);
  if (column == result.columns.end()) return std::nullopt;
  for (std::size_t i = 0; i < result.times.size(); ++i)
    if (std::abs(result.times[i] - *e.time) <= 1e-12 * (1.0 + std::abs(*e.time)))
      return column->second[i];
  return std::nullopt;
}

struct Verdict {
  int passed = 0, failed = 0, skipped = 0;
};

Verdict judge(const Script& script, const solver::RunResult& result) {
  Verdict verdict;
  for (const Expectation& e : script.model->expectations) {
    if (!e.active) {
      ++verdict.skipped;
      continue;
    }
    const auto value = value_at(result, e);
    const double bound = e.relative ? e.tolerance * std::abs(e.value) : e.tolerance;
    const double off = value ? std::abs(*value - e.value) : std::nan("");
    const bool good = value && off <= bound;
    good ? ++verdict.passed : ++verdict.failed;
    fmt::print("{} {} = {} (expected {} within {}{}){}{}\n", good ? "ok  " : "FAIL", e.probe,
               value ? fmt::format("{:.12g}", *value) : "not in the table", e.value, e.tolerance,
               e.relative ? " relative" : "", e.source.empty() ? "" : "  ", e.source);
  }
  return verdict;
}

/// The common part of run and test. Fills `result` on success.
int solve(Script& script, const Options& options, bool writes, solver::RunResult& result,
          std::optional<solver::AccuracyResult>& accuracy) {
  if (!compile_script(script, options)) return exit_script;
  solver::Discretisation discretisation;
  if (!discretise_script(script, discretisation)) return exit_script;
  if (options.strict) {
    const auto report = solver::check_hypotheses(*script.plan, discretisation);
    if (!report.discrete || !report.continuous) {
      std::fputs(hypotheses_text(script, report, options.colour_out).c_str(), stdout);
      return exit_hypothesis;
    }
  }
  solver::RunSettings settings;
  if (writes) settings.output_folder = output_folder(script, options);
  settings.name = script.model->title;
  settings.stop = &stop_flag();
  settings.monitors = options.monitors;
  if (writes) {
    settings.checkpoint_every = options.checkpoint;
    settings.resume = options.resume;
  }
  ProgressLine progress(!options.quiet);
  if (progress.enabled()) settings.progress = [&](const solver::Progress& p) { progress(p); };
  InterruptGuard guard;
  try {
    if (const auto request = accuracy_request(script, options)) {
      accuracy = solver::reach_accuracy(*script.plan, *request, settings, accuracy_teller(options));
      result = accuracy->run;
      script.plan = accuracy->plan;
    } else {
      result = solver::run(*script.plan, discretisation, settings, &result);
    }
    const auto& solved = accuracy ? *accuracy->discretisation : discretisation;
    result.script = script.path;
    if (options.resume && !options.quiet)
      fmt::print(stderr, "{}\n",
                 result.resumed_from > 0 ? fmt::format("resumed after step {}", result.resumed_from)
                                         : "began at the first step");
    if (writes)
      for (const std::string& file :
           draw_pictures(*script.plan, solved, result, output_folder(script, options)))
        result.files.push_back(file);
    return exit_ok;
  } catch (const solver::AccuracyFailure& failure) {
    accuracy = failure.so_far;
    if (!options.quiet) std::fputs(accuracy_text(*accuracy).c_str(), stdout);
    script.diagnostics.add(diagnose("E0705", Span{}, failure.what()).with_help(failure.help));
    return exit_solve;
  } catch (const solver::CheckpointFailure& failure) {
    script.diagnostics.add(diagnose("E0704", Span{}, failure.what()).with_help(failure.help));
    return exit_code(failure.kind);
  } catch (const solver::Failure& failure) {
    add_failure(script, failure);
    return exit_code(failure.kind);
  }
}

} // namespace

int run_command(const std::string& path, const Options& options) {
  Script script;
  script.path = path;
  solver::RunResult result;
  std::optional<solver::AccuracyResult> accuracy;
  double bandwidth = 0.0;
  int code = solve(script, options, !options.no_files, result, accuracy);
  if (code == exit_ok) {
    try {
      // Measuring takes as long as a short run.
      if (options.profile || (!options.json.empty() && result.timing.total > long_run))
        bandwidth = solver::read_bandwidth();
      write_json(script, result, options, accuracy, bandwidth);
    } catch (const solver::Failure& failure) {
      add_failure(script, failure);
      code = exit_code(failure.kind);
    }
  }
  show_diagnostics(script, options);
  if (code != exit_ok) {
    if (result.steps > 0 && !result.files.empty())
      fmt::print(stderr, "the results up to step {} are in {}/\n", result.steps,
                 output_folder(script, options));
    return code;
  }
  if (!options.quiet || options.json.empty())
    std::fputs(solver::aligned_text(table_of(result)).c_str(), stdout);
  if (options.quiet) return exit_ok;
  print_certificate(result, script);
  if (accuracy) std::fputs(accuracy_text(*accuracy).c_str(), stdout);
  if (options.profile) print_profile(result, bandwidth);
  if (!result.files.empty())
    fmt::print("files: {} in {}/\n", result.files.size(), output_folder(script, options));
  return exit_ok;
}

int test_command(const std::vector<std::string>& paths, const Options& options) {
  Verdict total;
  int errors = 0;
  for (const std::string& path : paths) {
    fmt::print("{}\n", path);
    Script script;
    script.path = path;
    solver::RunResult result;
    std::optional<solver::AccuracyResult> accuracy;
    const int code = solve(script, options, false, result, accuracy);
    show_diagnostics(script, options);
    if (code == exit_interrupted) return code;
    if (code != exit_ok) {
      ++errors;
      continue;
    }
    const Verdict verdict = judge(script, result);
    total.passed += verdict.passed;
    total.failed += verdict.failed;
    total.skipped += verdict.skipped;
    if (verdict.passed + verdict.failed == 0) fmt::print("     no expectation applies\n");
  }
  fmt::print("{} passed, {} failed, {} skipped{}\n", total.passed, total.failed, total.skipped,
             errors > 0 ? fmt::format(", {} scripts with errors", errors) : "");
  return total.failed + errors > 0 ? exit_expectation : exit_ok;
}

namespace {

/// The first steps, really taken: what they count is what the run counts, and their seconds say
/// what the others will take. But the sums of memories grow: those are rehearsed.
struct Forecast {
  solver::RunResult result;
  solver::MemoryForecast memory;
  double last = 0;                                       ///< CPU seconds after the last step taken
  double each = std::numeric_limits<double>::infinity(); ///< of the cheapest: first ones prepare
  int taken = 0, steps = 0;
  bool friction = false;
  /// Of the memories after the steps taken, beyond what the first of them took.
  double history() const {
    const auto& r = result;
    const double bytes = sizeof(double) * (r.path.empty() ? r.contact_unknowns : r.unknowns);
    return memory.reads > 0.0 || memory.seconds > 0.0
               ? memory.seconds + memory.reads * bytes / solver::read_bandwidth()
               : 0.0;
  }
  /// Without files.
  double seconds() const {
    if (taken >= steps) return result.timing.mesh + last;
    // In the first steps everything sticks; those with slip cost about half as much again.
    const double later = friction ? 1.5 * each : each;
    return result.timing.mesh + last + later * (steps - taken) + history();
  }
};

Forecast forecast(const solver::Plan& plan, const solver::Discretisation& discretisation) {
  Forecast out;
  out.friction = std::any_of(plan.laws.begin(), plan.laws.end(),
                             [](const solver::LawSpec& law) { return law.radial; });
  std::atomic<bool> stop = false;
  solver::RunSettings settings;
  settings.stop = &stop;
  settings.progress = [&](const solver::Progress& p) {
    if (p.step > 1) out.each = std::min(out.each, p.seconds - out.last);
    out.last = p.seconds, out.taken = p.step, out.steps = p.steps;
    stop = p.step >= std::clamp(p.steps / 50, 8, 24);
  };
  try {
    out.result = solver::run(plan, discretisation, settings, &out.result);
  } catch (const solver::Failure& failure) {
    if (failure.kind != solver::FailureKind::interrupted) throw;
  }
  if (out.taken < out.steps) out.memory = solver::rehearse_memory(plan, out.taken);
  return out;
}

void print_forecast(const Forecast& f) {
  const auto& r = f.result;
  const auto& w = r.work;
  const std::string evolution = r.path.empty()
                                    ? "contact unknowns: all tensors are multiples of one tensor"
                                    : "all unknowns: " + r.path;
  fmt::print("evolution on {}\n", evolution);
  fmt::print("{} unknowns, {} of them in contact laws; {} {}, {} analys{}, {} factorisation{}\n",
             r.unknowns, r.contact_unknowns, w.matrices, w.matrices == 1 ? "matrix" : "matrices",
             w.analyses, w.analyses == 1 ? "is" : "es", w.factorisations,
             w.factorisations == 1 ? "" : "s");
  const double per_step = f.taken > 0 ? 1.0 / f.taken : 0.0;
  fmt::print("a step: {:.3g} sweeps, {:.3g} products, {:.3g} Newton iterations; {:.3g} MB held\n",
             w.sweeps * per_step, w.products * per_step, w.newton * per_step, w.bytes / 1e6);
  const std::string rehearsed =
      f.memory.rehearsed > 0 ? fmt::format("; {} of its memory alone", f.memory.rehearsed) : "";
  fmt::print("predicted: {:.3g} s for {} step{}, without files (from the first {}{})\n",
             f.seconds(), f.steps, f.steps == 1 ? "" : "s", f.taken, rehearsed);
}

/// The effects as declared, or with what the first steps showed of them.
void print_effects(const Script& script, const std::optional<Forecast>& first_steps) {
  using State = solver::EffectNote::State;
  const bool ran = first_steps && !first_steps->result.effects.empty();
  for (const solver::EffectNote& note : ran ? first_steps->result.effects : script.plan->effects) {
    const char* state = note.state == State::on        ? "on"
                        : note.state == State::off     ? "off"
                        : note.state == State::dropped ? "dropped"
                                                       : "asleep";
    const int line = line_of(script, note.origin);
    std::string why = note.why.empty() ? "" : ": " + note.why;
    const bool may_change = note.state == State::asleep || note.why.starts_with("linear");
    if (ran && may_change && first_steps->taken < first_steps->steps)
      why += fmt::format(" up to step {}", first_steps->taken);
    fmt::print("{:<8} {}{}{}\n", state, note.name, line > 0 ? fmt::format(", line {}", line) : "",
               why);
  }
}

} // namespace

int plan_command(const std::string& path, const Options& options) {
  Script script;
  script.path = path;
  if (!compile_script(script, options)) {
    show_diagnostics(script, options);
    return exit_script;
  }
  show_diagnostics(script, options);
  std::vector<solver::HistoryReport> memory;
  try {
    memory = solver::planned_memory(*script.plan);
  } catch (const solver::Failure& failure) {
    add_failure(script, failure);
    show_diagnostics(script, options);
    return exit_code(failure.kind);
  }
  solver::Discretisation discretisation;
  std::optional<Forecast> first_steps;
  try {
    if (discretise_script(script, discretisation))
      first_steps = forecast(*script.plan, discretisation);
  } catch (const solver::Failure& failure) {
    add_failure(script, failure);
  }
  print_effects(script, first_steps);
  print_memory(*script.plan, memory);
  fmt::print("{} forms, {} memory fields, {} laws, {} loads\n", script.plan->forms.size(),
             script.plan->histories.size(), script.plan->law_terms.size(),
             script.plan->loads.size());
  if (first_steps) print_forecast(*first_steps);
  if (!script.diagnostics.has_errors()) return exit_ok;
  show_diagnostics(script, options);
  return exit_script;
}

} // namespace hvi::lang
