// hvi-run check: the mistakes of a script, then the hypotheses of the theory as numbers.
#include "lang/check_report.hpp"
#include "lang/driver.hpp"
#include "lang/mesh_report.hpp"
#include "lang/mesh_values.hpp"
#include "lang/outputs.hpp"
#include "lang/say.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/time/step.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace hvi::lang {

namespace {

/// Mesh, parts and the first step's matrix, which tells whether all forms together determine the
/// unknown. Mistakes become diagnostics.
bool check_on_mesh(Script& script, solver::Discretisation& discretisation) {
  try {
    for (const solver::Failure& failure : solver::discretise(*script.plan, discretisation))
      add_failure(script, failure);
    if (!script.diagnostics.has_errors()) report_misfits(script, discretisation);
    if (!script.diagnostics.has_errors()) check_materials(script, discretisation);
    if (!script.diagnostics.has_errors()) {
      solver::Timing timing;
      solver::Stepper stepper(*script.plan, discretisation, timing);
      stepper.advance(1);
    }
  } catch (const solver::TooLarge&) {
    throw; // no mistake of the script
  } catch (const solver::Failure& failure) {
    add_failure(script, failure);
  }
  return !script.diagnostics.has_errors();
}

/// Hypotheses of a script without mistakes; false under --strict when the theorem does not apply.
bool judge_script(Script& script, const solver::Discretisation& discretisation,
                  const Options& options) {
  const auto report = solver::check_hypotheses(*script.plan, discretisation);
  if (!options.quiet && options.json != "-")
    std::fputs(hypotheses_text(script, report, options.colour_out).c_str(), stdout);
  if (!options.json.empty()) write_json_text(options, hypotheses_json(script, report));
  return !options.strict || (report.discrete && report.continuous);
}

int check_one(const std::string& path, const Options& options) {
  Script script;
  script.path = path;
  solver::Discretisation discretisation;
  bool good = compile_script(script, options), applies = true;
  HeldOutputs outputs;
  int refused = exit_ok;
  if (good && !outputs.take(outputs_in("", {}, options), options, script, refused)) {
    show_diagnostics(script, options);
    return refused;
  }
  if (script.plan && !options.script_only) good = check_on_mesh(script, discretisation) && good;
  show_diagnostics(script, options);
  if (!good) return exit_script;
  if (!options.quiet && options.json != "-") say("{}: ok\n", path);
  if (options.script_only) return exit_ok;
  try {
    applies = judge_script(script, discretisation, options);
  } catch (const solver::Failure& failure) {
    if (failure.kind == solver::FailureKind::output) {
      tell("error[E0702]: {}\n", failure.what());
      return exit_solve;
    }
    tell("the hypotheses cannot be judged: {}\n", failure.what());
    return options.strict ? exit_hypothesis : exit_ok;
  }
  return applies ? exit_ok : exit_hypothesis;
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
