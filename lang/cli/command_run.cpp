// hvi-run run and test: solving, and judging expectations.
#include "lang/cli/accuracy_report.hpp"
#include "lang/cli/check_report.hpp"
#include "lang/cli/commands.hpp"
#include "lang/cli/interrupt.hpp"
#include "lang/cli/outputs.hpp"
#include "lang/cli/run_report.hpp"
#include "lang/cli/say.hpp"
#include "lang/cli/time_left.hpp"
#include "lang/pictures.hpp"
#include "lang/report/page.hpp"
#include "solver/linear/bandwidth.hpp"
#include "solver/linear/processes.hpp"
#include "solver/results/result_json.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

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
    left_.note(p.step, std::chrono::duration<double>(now - start_).count());
    tell("\r\033[Kstep {}/{}  {} Newton  {:.0f} s left", p.step, p.steps, p.newton,
         left_.estimate(p.steps));
    if (p.step == p.steps) tell("\r\033[K");
    std::fflush(stderr);
  }

private:
  bool enabled_;
  TimeLeft left_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_{};
};

constexpr double long_run = 0.2; ///< CPU seconds from which the JSON has the measured bandwidth

nlohmann::ordered_json json_of(const Session& session, double bandwidth) {
  solver::ResultContext context = json_context(session.script);
  context.bandwidth = bandwidth;
  auto out = solver::result_json(session.result, session.script.plan->problem, context);
  if (session.accuracy) out["accuracy"] = accuracy_json(*session.accuracy);
  return out;
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
    if (is_at(result.times[i], *e.time)) return column->second[i];
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
    say("{} {}{} = {} (expected {} within {}{}){}{}\n", good ? "ok  " : "FAIL", e.probe,
        e.time ? fmt::format(" at t = {}", *e.time) : "",
        value ? fmt::format("{:.12g}", *value) : "not in the table", e.value, e.tolerance,
        e.relative ? " relative" : "", e.source.empty() ? "" : "  ", e.source);
  }
  return verdict;
}

/// Prints the hypotheses where the theorem does not apply.
Exit judge_strictly(Session& session, const Options& options) {
  if (!options.strict) return exit_ok;
  solver::HypothesisReport report;
  const Exit code = session.attempt(
      [&] { report = solver::check_hypotheses(*session.script.plan, session.discretisation); });
  if (code != exit_ok || (report.discrete && report.continuous)) return code;
  std::fputs(hypotheses_text(session.script, report, options.colour_out).c_str(), stdout);
  return exit_hypothesis;
}

RunRequest request_of(const Session& session, const Options& options, ProgressLine& progress) {
  RunRequest out;
  auto& settings = out.settings;
  settings.name = session.script.model->title;
  settings.stop = &stop_flag();
  settings.warn = warn_of_file;
  settings.monitors = options.monitors || options.report;
  settings.condition = options.report || !options.json.empty();
  if (!options.no_files) {
    settings.output_folder = output_folder(session.script, options);
    settings.checkpoint_every = options.checkpoint;
    settings.resume = options.resume;
    settings.processes = solver::started_processes().count;
  }
  if (progress.enabled()) settings.progress = [&](const solver::Progress& p) { progress(p); };
  out.accuracy = options.accuracy;
  out.accuracy_of = options.accuracy_of;
  out.as_written = options.as_written;
  constexpr double an_hour = 3600.0;
  out.budget = options.budget.value_or(an_hour);
  out.tell_accuracy = accuracy_teller(options);
  return out;
}

/// Is something said of an accuracy that nothing asks for?
bool lacks_accuracy(const Script& script, const Options& options) {
  if (options.accuracy > 0.0 || script.model->accuracy) return false;
  if (options.accuracy_of.empty() && !options.as_written && !options.budget) return false;
  tell("hvi-run: {} goes with --accuracy, or with `using accuracy` in the script\n",
       options.as_written ? "--as-written"
       : options.budget   ? "--budget"
                          : "--of");
  return true;
}

/// The common part of run and test: the phases, each with what the options ask of it.
Exit solve(Session& session, const Options& options, HeldOutputs& outputs) {
  if (const Exit code = session.compile(); code != exit_ok) return code;
  if (lacks_accuracy(session.script, options)) return exit_usage;
  const Outputs wanted = outputs_of_run(session.script, options);
  if (const Exit code = outputs.take(wanted, options, session); code != exit_ok) return code;
  if (const Exit code = session.discretise(&stop_flag()); code != exit_ok) return code;
  if (const Exit code = judge_strictly(session, options); code != exit_ok) return code;
  ProgressLine progress(!options.quiet);
  const InterruptGuard guard;
  const Exit code = session.run(request_of(session, options, progress));
  if (code == exit_ok && options.resume && !options.quiet)
    tell("{}\n", session.result.resumed_from > 0
                     ? fmt::format("resumed after step {}", session.result.resumed_from)
                     : "began at the first step");
  if (code != exit_ok && session.accuracy && !options.quiet && !json_only(options))
    std::fputs(accuracy_text(*session.accuracy).c_str(), stdout);
  return code;
}

void write_result(Session& session, const Options& options, double bandwidth, int& code) {
  if (options.json.empty()) return;
  try {
    write_json(options, json_of(session, bandwidth));
  } catch (const solver::Failure& failure) {
    code = session.refuse(failure);
  }
}

/// Done last: the module that draws may be missing, and pictures show nothing that is not in the
/// files.
void add_pictures(Session& session, const Options& options, double bandwidth, int& code) {
  bool any = false;
  for (const Drawn& picture : draw_pictures(session.script, session.result, session.shown,
                                            output_folder(session.script, options))) {
    if (!picture.failure) {
      session.result.files.push_back(picture.file);
      any = true;
    } else if (picture.asked_by_name) {
      code = session.refuse(*picture.failure);
    } else {
      session.warn("W0601", *picture.failure, picture.origin);
    }
  }
  if (any && !json_only(options)) write_result(session, options, bandwidth, code);
}

/// The page of a run, with the hypotheses where they can be judged.
void add_page(Session& session, const Options& options, double bandwidth, int& code) {
  Script& script = session.script;
  ReportParts parts{script};
  parts.result = json_of(session, bandwidth);
  parts.run = &session.result;
  parts.frames = session.shown.frames, parts.frames_since = session.shown.since;
  try {
    parts.hypotheses = hypotheses_json(
        script, solver::check_hypotheses(*script.plan, session.last_discretisation()));
  } catch (const solver::Failure& failure) {
    tell("the hypotheses cannot be judged: {}\n", failure.what());
  }
  const Exit done = session.attempt(
      [&] { write_page(output_folder(script, options), script.model->title, parts); });
  if (done != exit_ok) code = done;
  if (done == exit_ok && !options.quiet && !json_only(options))
    say("report: {}/{}{}\n", output_folder(script, options), script.model->title, report_ending);
}

/// Files first, then printing, then pictures: a failure loses nothing that came before.
int report_run(Session& session, const Options& options) {
  int code = exit_ok;
  const auto& result = session.result;
  if (result.unwritten) code = session.refuse(*result.unwritten);
  // Measuring takes as long as a short run.
  const bool measures =
      options.profile || (!options.json.empty() && result.timing.total > long_run);
  const double bandwidth = measures ? solver::read_bandwidth() : 0.0;
  write_result(session, options, bandwidth, code);
  if (!json_only(options)) print_result(session, options, bandwidth);
  std::fflush(stdout);
  if (!options.no_files) add_pictures(session, options, bandwidth, code);
  if (options.report) add_page(session, options, bandwidth, code);
  if (!options.quiet && !json_only(options) && !result.files.empty())
    say("files: {} in {}/\n", result.files.size(), output_folder(session.script, options));
  return code;
}

} // namespace

int run_command(const std::string& path, const Options& options) {
  HeldOutputs outputs;
  CompileSettings settings = compile_settings(options);
  settings.keep_fields = options.report;
  Session session(path, std::move(settings));
  int code = solve(session, options, outputs);
  if (code == exit_ok) {
    code = report_run(session, options);
    show_diagnostics(session.script, options);
    return code;
  }
  show_diagnostics(session.script, options);
  const auto& result = session.result;
  if (result.steps > 0 && !result.files.empty())
    tell("the results up to step {} are in {}/\n", result.steps,
         output_folder(session.script, options));
  return code;
}

int test_command(const std::vector<std::string>& paths, const Options& options) {
  Verdict total;
  int errors = 0;
  Options prints_only = options;
  prints_only.no_files = true;
  prints_only.json.clear();
  prints_only.report = false;
  for (const std::string& path : paths) {
    say("{}\n", path);
    HeldOutputs outputs;
    Session session(path, compile_settings(options));
    const Exit code = solve(session, prints_only, outputs);
    show_diagnostics(session.script, options);
    if (code == exit_interrupted) return code;
    if (code != exit_ok) {
      ++errors;
      continue;
    }
    const Verdict verdict = judge(session.script, session.result);
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
