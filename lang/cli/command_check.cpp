// hvi-run check: the mistakes of a script, then the hypotheses of the theory as numbers.
#include "lang/cli/check_report.hpp"
#include "lang/cli/commands.hpp"
#include "lang/cli/outputs.hpp"
#include "lang/cli/say.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>

namespace hvi::lang {

namespace {

/// Hypotheses of a script without mistakes; exit_hypothesis when the theorem does not apply and
/// that is asked for.
Exit judge_script(Session& session, const Options& options) {
  const auto report = solver::check_hypotheses(*session.script.plan, session.discretisation);
  if (!options.quiet && !json_only(options))
    std::fputs(hypotheses_text(session.script, report, options.colour_out).c_str(), stdout);
  if (!options.json.empty()) write_json(options, hypotheses_json(session.script, report));
  if (options.report) {
    ReportParts parts{session.script};
    parts.hypotheses = hypotheses_json(session.script, report);
    write_page(output_folder(session.script, options), session.script.model->title, parts);
  }
  return !options.strict || (report.discrete && report.continuous) ? exit_ok : exit_hypothesis;
}

/// The phases up to the first step; every mistake is a diagnostic.
Exit look_for_mistakes(Session& session, const Options& options, HeldOutputs& outputs) {
  if (const Exit code = session.compile(); code != exit_ok) return code;
  const Script& script = session.script;
  const std::vector<std::string> page{script.model->title + report_ending};
  const Outputs wanted = options.report ? outputs_in(output_folder(script, options), page, options)
                                        : outputs_in("", {}, options);
  if (const Exit code = outputs.take(wanted, options, session); code != exit_ok) return code;
  if (options.script_only) return exit_ok;
  return session.try_out();
}

int check_one(const std::string& path, const Options& options) {
  HeldOutputs outputs;
  Session session(path, compile_settings(options));
  const Exit code = look_for_mistakes(session, options, outputs);
  show_diagnostics(session.script, options);
  if (code != exit_ok) return code;
  if (!options.quiet && !json_only(options)) say("{}: ok\n", path);
  if (options.script_only) return exit_ok;
  try {
    return judge_script(session, options);
  } catch (const solver::Failure& failure) {
    if (solver::concerns_output(failure.kind)) {
      const Ending ending = ending_of(failure.kind);
      tell("error[{}]: {}\n", ending.code, failure.what());
      return ending.exit;
    }
    tell("the hypotheses cannot be judged: {}\n", failure.what());
    return options.strict ? exit_hypothesis : exit_ok;
  }
}

} // namespace

int check_command(const std::vector<std::string>& paths, const Options& options) {
  int code = exit_ok;
  for (const std::string& path : paths) {
    const int one = check_one(path, options);
    if (code == exit_ok || one == exit_script) code = one;
  }
  return code;
}

} // namespace hvi::lang
