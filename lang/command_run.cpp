// hvi-run run, test and plan: solving, judging expectations, saying what would be done.
#include "lang/accuracy_report.hpp"
#include "lang/check_report.hpp"
#include "lang/driver.hpp"
#include "lang/interrupt.hpp"
#include "lang/memory_lines.hpp"
#include "lang/mesh_values.hpp"
#include "lang/outputs.hpp"
#include "lang/pictures.hpp"
#include "lang/say.hpp"
#include "solver/linear/bandwidth.hpp"
#include "solver/output/table.hpp"
#include "solver/time/checkpoint.hpp"
#include "solver/time/report.hpp"
#include "solver/time/result_json.hpp"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

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
    tell("\r\033[Kstep {}/{}  {} Newton  {:.0f} s left", p.step, p.steps, p.newton,
         wall * (p.steps - p.step) / p.step);
    if (p.step == p.steps) tell("\r\033[K");
    std::fflush(stderr);
  }

private:
  bool enabled_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_{};
};

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
  say("energy: {:.9g} = elastic {:.9g} + contact {:.9g} - load\n", last("energy"), last("elastic"),
      last("contact"));
  say("work: {:.9g}; viscous {:.6g}, memory {:.6g}, lost {:.6g} (balance to {:.1e})\n",
      last("work"), last("viscous"), last("memory"), last("lost"), m.balance_error);
  say("lemma 3.2: max|u| {:.6g}, sum|du|^2 {:.6g}, max|xi| {:.6g}, sum k|du/k|^2 {:.6g}\n",
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
  say("rounding: changes {} by about {:.1e} of its size{}{}\n", of, worst, condition,
      error.refined ? ", steps refined in extended precision" : "");
}

void print_certificate(const solver::RunResult& r, const Script& script) {
  const solver::Certificate& c = r.certificate;
  if (c.certified)
    say("certified: {}, worst inclusion {:.1e} at step {}, worst equilibrium {:.1e} at step "
        "{}, tolerance {:.0e}\n",
        r.steps == 1 ? "1 step" : fmt::format("all {} steps", r.steps), c.inclusion,
        c.inclusion_step, c.equilibrium, c.equilibrium_step, c.tolerance);
  print_forward_error(r.forward_error);
  if (r.work.followed_steps > 0)
    say("{} steps followed their branch by {} inner steps\n", r.work.followed_steps,
        r.work.inner_steps);
  if (r.work.unfollowed_steps > 0)
    say("note: {} steps may have left their branch: it was not followed (a vector law, more "
        "than 1200 points, forms without symmetry, bounds found together with their laws, or a "
        "curve without a further stable state); their answers may depend on the number of steps\n",
        r.work.unfollowed_steps);
  if (r.work.fallback_steps > 0)
    say("steps that only the globally convergent method solved: {}\n", r.work.fallback_steps);
  if (r.monitors) print_monitors(*r.monitors);
  print_memory(*script.plan, r.histories);
  for (const solver::StepNote& note : r.notes) {
    const int line = line_of(script, note.origin);
    const std::string when =
        note.step > 0 ? fmt::format("step {} (t = {:.6g}): ", note.step, note.t) : std::string();
    say("note: {}{}{}\n", when, note.what, line > 0 ? fmt::format(" (line {})", line) : "");
  }
  if (r.energy) say("energy of this branch at the end: {:.9g}\n", *r.energy);
}

constexpr double long_run = 0.2; ///< CPU seconds from which the JSON has the measured bandwidth

/// Phases, counted work, and the lower limit of the triangular solves: one read of the factor each.
void print_profile(const solver::RunResult& r, double bandwidth) {
  const auto& t = r.timing;
  const double steps = std::max(1, r.steps);
  const double rest = t.total - t.mesh - t.assembly - t.ordering - t.factor - t.steps - t.output;
  tell("{:<24}{:>12}{:>14}{:>20}\n", "profile", "CPU seconds", "ms per step", "ms, the limit");
  const auto line = [&](const char* name, double seconds, bool each, double limit = 0.0) {
    tell("{:<24}{:>12.4f}{:>14}{:>20}\n", name, seconds,
         each ? fmt::format("{:.4f}", 1e3 * seconds / steps) : "",
         limit > 0.0 ? fmt::format("{:.4f}", 1e3 * limit / steps) : "");
  };
  line("mesh", t.mesh, false), line("assembly", t.assembly, false);
  line("ordering", t.ordering, false), line("factorisation", t.factor, false);
  line("steps", t.steps, true), line("  history (wall)", t.history, true);
  line("  solves (wall)", t.sweeps, true, t.swept_bytes / bandwidth),
      line("  inequality (wall)", t.inequality, true);
  line("output", t.output, true), line("set-up besides", std::max(0.0, rest), false);
  line("total", t.total, false);
  const auto& w = r.work;
  tell("counted: {} unknowns, {} steps, {} matrices, {} analyses, {} factorisations, {} "
       "triangular solves, {} products, {} Newton, {} fields read {} times\n",
       r.unknowns, r.steps, w.matrices, w.analyses, w.factorisations, w.sweeps, w.products,
       w.newton, w.history_fields, w.field_reads);
  tell("the limit: every triangular solve reads its factor once, {:.3g} MB in all, at the {:.3g} "
       "GB/s "
       "measured on this machine\nheld: {:.3g} MB (factors, matrices, memory)\n",
       t.swept_bytes / 1e6, bandwidth / 1e9, w.bytes / 1e6);
}

std::string json_of(const Script& script, const solver::RunResult& result,
                    const std::optional<solver::AccuracyResult>& accuracy, double bandwidth) {
  solver::ResultContext context = json_context(script);
  context.bandwidth = bandwidth;
  std::string text = solver::result_json(result, *script.plan, context);
  return accuracy ? with_accuracy(text, *accuracy) : text;
}

void warn_of_file(const std::string& what) { tell("warning: {}; the run goes on\n", what); }

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
    say("{} {} = {} (expected {} within {}{}){}{}\n", good ? "ok  " : "FAIL", e.probe,
        value ? fmt::format("{:.12g}", *value) : "not in the table", e.value, e.tolerance,
        e.relative ? " relative" : "", e.source.empty() ? "" : "  ", e.source);
  }
  return verdict;
}

/// What a script becomes. Kept together: the results point into the discretisation.
struct Solved {
  solver::Discretisation discretisation;
  solver::RunResult result;
  std::optional<solver::AccuracyResult> accuracy;
  const solver::Discretisation& last() const {
    return accuracy ? *accuracy->discretisation : discretisation;
  }
};

/// The common part of run and test. Fills `solved` on success.
int solve(Script& script, const Options& options, bool writes, HeldOutputs& outputs,
          Solved& solved) {
  auto& [discretisation, result, accuracy] = solved;
  if (!compile_script(script, options)) return exit_script;
  int refused = exit_ok;
  if (!outputs.take(outputs_of_run(script, options), options, script, refused)) return refused;
  if (const int code = discretise_script(script, discretisation); code != exit_ok) return code;
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
  settings.warn = warn_of_file;
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
    result.script = script.path;
    if (options.resume && !options.quiet)
      tell("{}\n", result.resumed_from > 0
                       ? fmt::format("resumed after step {}", result.resumed_from)
                       : "began at the first step");
    return exit_ok;
  } catch (const solver::AccuracyFailure& failure) {
    accuracy = failure.so_far;
    if (!options.quiet && !json_only(options)) std::fputs(accuracy_text(*accuracy).c_str(), stdout);
    script.diagnostics.add(diagnose("E0705", Span{}, failure.what()).with_help(failure.help));
    return exit_solve;
  } catch (const solver::CheckpointFailure& failure) {
    script.diagnostics.add(diagnose("E0704", Span{}, failure.what()).with_help(failure.help));
    return exit_code(failure);
  } catch (const solver::Failure& failure) {
    add_failure(script, failure);
    return exit_code(failure);
  }
}

/// Reports at the end that a requested file could not be written; everything else is done.
void add_unwritten(Script& script, const std::string& what, const std::string& help, int& code) {
  script.diagnostics.add(diagnose("E0702", Span{}, what).with_help(help));
  code = exit_solve;
}

void write_json(Script& script, Solved& solved, const Options& options, double bandwidth,
                int& code) {
  if (options.json.empty()) return;
  try {
    write_json_text(options, json_of(script, solved.result, solved.accuracy, bandwidth));
  } catch (const solver::Failure& failure) {
    add_unwritten(script, failure.what(), failure.help, code);
  }
}

/// Done last: gnuplot may be missing, and pictures show nothing that is not in the files.
void add_pictures(Script& script, Solved& solved, const Options& options, double bandwidth,
                  int& code) {
  bool any = false;
  for (const Drawn& picture :
       draw_pictures(*script.plan, solved.last(), solved.result, output_folder(script, options))) {
    if (picture.failure.empty()) {
      solved.result.files.push_back(picture.file);
      any = true;
    } else if (picture.asked_by_name) {
      add_unwritten(script, picture.failure, picture.help, code);
    } else {
      const Span span = script.model->origins[static_cast<std::size_t>(picture.origin.id)];
      script.diagnostics.add(diagnose("W0601", span, picture.failure).with_help(picture.help));
    }
  }
  if (any && !json_only(options)) write_json(script, solved, options, bandwidth, code);
}

void print_result(const Script& script, const Solved& solved, const Options& options,
                  double bandwidth) {
  if (!options.quiet || options.json.empty())
    std::fputs(solver::aligned_text(table_of(solved.result)).c_str(), stdout);
  if (options.quiet) return;
  print_certificate(solved.result, script);
  if (solved.accuracy) std::fputs(accuracy_text(*solved.accuracy).c_str(), stdout);
  if (options.profile) print_profile(solved.result, bandwidth);
}

/// Files first, then printing, then pictures: a failure loses nothing that came before.
int report_run(Script& script, Solved& solved, const Options& options) {
  int code = exit_ok;
  const auto& result = solved.result;
  if (!result.unwritten.empty())
    add_unwritten(script, result.unwritten, result.unwritten_help, code);
  // Measuring takes as long as a short run.
  const bool measures =
      options.profile || (!options.json.empty() && result.timing.total > long_run);
  const double bandwidth = measures ? solver::read_bandwidth() : 0.0;
  write_json(script, solved, options, bandwidth, code);
  if (!json_only(options)) print_result(script, solved, options, bandwidth);
  std::fflush(stdout);
  if (!options.no_files) add_pictures(script, solved, options, bandwidth, code);
  if (!options.quiet && !json_only(options) && !result.files.empty())
    say("files: {} in {}/\n", result.files.size(), output_folder(script, options));
  return code;
}

} // namespace

int run_command(const std::string& path, const Options& options) {
  Script script;
  script.path = path;
  HeldOutputs outputs;
  Solved solved;
  int code = solve(script, options, !options.no_files, outputs, solved);
  if (code == exit_ok) {
    code = report_run(script, solved, options);
    show_diagnostics(script, options);
    return code;
  }
  show_diagnostics(script, options);
  const auto& result = solved.result;
  if (result.steps > 0 && !result.files.empty())
    tell("the results up to step {} are in {}/\n", result.steps, output_folder(script, options));
  return code;
}

int test_command(const std::vector<std::string>& paths, const Options& options) {
  Verdict total;
  int errors = 0;
  for (const std::string& path : paths) {
    say("{}\n", path);
    Script script;
    script.path = path;
    HeldOutputs outputs;
    Solved solved;
    Options prints_only = options;
    prints_only.no_files = true;
    prints_only.json.clear();
    const int code = solve(script, prints_only, false, outputs, solved);
    show_diagnostics(script, options);
    if (code == exit_interrupted) return code;
    if (code != exit_ok) {
      ++errors;
      continue;
    }
    const Verdict verdict = judge(script, solved.result);
    total.passed += verdict.passed;
    total.failed += verdict.failed;
    total.skipped += verdict.skipped;
    if (verdict.passed + verdict.failed == 0) say("     no expectation applies\n");
  }
  say("{} passed, {} failed, {} skipped{}\n", total.passed, total.failed, total.skipped,
      errors > 0 ? fmt::format(", {} scripts with errors", errors) : "");
  return total.failed + errors > 0 ? exit_expectation : exit_ok;
}

} // namespace hvi::lang
