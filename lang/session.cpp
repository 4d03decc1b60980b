// Chains the phases. Each arrow of the pipeline map is one call here.
#include "lang/session.hpp"

#include "lang/check/check.hpp"
#include "lang/lower/lower.hpp"
#include "lang/mesh_report.hpp"
#include "lang/mesh_sides.hpp"
#include "lang/mesh_tables.hpp"
#include "lang/mesh_values.hpp"
#include "lang/stdlib.hpp"
#include "lang/units/units.hpp"
#include "solver/common/joined.hpp"
#include "solver/hypotheses/load_space.hpp"
#include "solver/hypotheses/load_time.hpp"
#include "solver/results/field_grids.hpp"
#include "solver/step/step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

namespace hvi::lang {

namespace {

namespace fs = std::filesystem;

/// What is asked for, else what the script wants. Throws Failure(bad_value) for a column that the
/// report does not have.
std::optional<solver::AccuracyRequest> accuracy_wanted(const Script& script,
                                                       const RunRequest& request) {
  solver::AccuracyRequest out;
  if (request.accuracy > 0.0)
    out.wanted = request.accuracy, out.probe = request.accuracy_of;
  else if (script.model->accuracy)
    out.wanted = *script.model->accuracy,
    out.probe = request.accuracy_of.empty() ? script.model->accuracy_of : request.accuracy_of;
  else if (!request.accuracy_of.empty())
    throw solver::Failure(solver::FailureKind::bad_value, {},
                          "the accuracy of `" + request.accuracy_of +
                              "` is asked for, and none given",
                          "say how large its relative error may be");
  else
    return std::nullopt;
  out.most_seconds = request.budget;
  out.as_written = request.as_written;
  const auto& probes = script.plan->report.probes;
  const auto is_it = [&](const solver::Probe& p) { return p.name == out.probe; };
  if (!out.probe.empty() && std::none_of(probes.begin(), probes.end(), is_it)) {
    std::vector<std::string> names;
    for (const auto& p : probes) // parts of other columns have no name
      if (!p.name.empty()) names.push_back(p.name);
    throw solver::Failure(solver::FailureKind::bad_value, {},
                          "no column `" + out.probe + "` whose accuracy could be asked for",
                          "the report has: " + solver::joined(names));
  }
  return out;
}

/// `fields sigma` at the end of the report: the checker knows what the stress of a script is.
void ask_for_stress(ast::Program& program) {
  ast::FieldsItem item;
  ast::Expr stress;
  stress.node = ast::Reference{"sigma"};
  item.fields.push_back(std::move(stress));
  const auto last =
      std::find_if(program.statements.rbegin(), program.statements.rend(),
                   [](const ast::Statement& s) { return std::holds_alternative<ast::Report>(s); });
  if (last != program.statements.rend()) {
    std::get<ast::Report>(*last).items.emplace_back(std::move(item));
    return;
  }
  ast::Report report;
  report.items.emplace_back(std::move(item));
  program.statements.emplace_back(std::move(report));
}

/// Does it live at the points of a law alone?
bool of_laws(const solver::FieldSpec& field) {
  return std::ranges::any_of(field.components, [](const solver::Expr& e) {
    return e.depends_on_any(solver::slot::first_multiplier, solver::slot::first_inside);
  });
}

/// The unknowns, what `ask_for_stress` asked for, which goes from the plan, and the script's own
/// fields of the body.
solver::Shown shown_of(solver::Plan& plan, const Model& model) {
  solver::Shown out;
  out.fields = solver::unknown_fields(plan.problem, model.dim);
  for (std::size_t b = 0; b < out.fields.size(); ++b)
    if (const auto unit = model.units.of.find(model.unknowns[b]); unit != model.units.of.end())
      out.fields[b].unit = unit->second;
  for (auto& field : plan.report.fields.back().fields) out.fields.push_back(std::move(field));
  plan.report.fields.pop_back();
  for (const auto& files : plan.report.fields)
    for (const auto& field : files.fields) {
      const auto known = [&](const solver::FieldSpec& other) {
        return other.name == field.name || other.components == field.components;
      };
      if (!of_laws(field) && std::ranges::none_of(out.fields, known)) out.fields.push_back(field);
    }
  return out;
}

/// The place in time of a load that has no integral there; nothing where none is found.
std::optional<solver::TimeSingularity> pole_of(const solver::LoadTerm& load,
                                               const std::vector<double>& grid) {
  for (const auto& entry : load.entries)
    if (const auto found = solver::time_singularity(entry.value, grid.front(), grid.back());
        found && found->exponent >= 1.0)
      return found;
  return std::nullopt;
}

/// Does a module of the library declare this name? `superpotential winkler(...)`, `mesh unit_square
/// = ...`
bool declares(std::string_view module, std::string_view name) {
  for (std::size_t at = module.find(name); at != std::string_view::npos;
       at = module.find(name, at + 1)) {
    const std::size_t line = module.rfind('\n', at) + 1; // npos + 1 is the beginning
    const std::string_view before = module.substr(line, at - line);
    const std::string_view after = module.substr(at + name.size(), 2);
    const bool one_word = before.size() > 1 && before.find(' ') == before.size() - 1;
    if (one_word && before[0] != '#' && (after.starts_with('(') || after.starts_with(" =")))
      return true;
  }
  return false;
}

/// Names that the script would have with an import get the import as help.
void propose_imports(Script& script) {
  Diagnostics out;
  for (Diagnostic one : script.diagnostics.items()) {
    const auto open = one.message.find('`'), close = one.message.rfind('`');
    if (one.code == "E0301" && close > open + 1 && close != std::string::npos) {
      const std::string name = one.message.substr(open + 1, close - open - 1);
      for (const Module& module : standard_library())
        if (declares(module.text, name))
          one.help = fmt::format("`{}` is in a module of the standard library: `import {}`", name,
                                 module.name);
    }
    out.add(std::move(one));
  }
  script.diagnostics = std::move(out);
}

} // namespace

Session::Session(std::string path, CompileSettings settings, std::optional<std::string> text)
    : settings_(std::move(settings)) {
  script.path = std::move(path);
  script.text = std::move(text);
}

Exit Session::parse() {
  parse_script(script);
  return script.diagnostics.has_errors() || script.programs.empty() ? exit_script : exit_ok;
}

Exit Session::compile() {
  parse_script(script);
  if (script.programs.empty()) return exit_script;
  if (settings_.keep_fields) ask_for_stress(script.programs.front());
  CheckOptions options;
  options.defines = settings_.defines;
  options.folder = (fs::path(script.path).parent_path() / ".").lexically_normal().string();
  options.title = fs::path(script.path).stem().string();
  options.allow_geo = settings_.allow_geo;
  options.words = settings_.words;
  options.on_name = settings_.on_name;
  const units::ScriptUnits units = units::read_units(script.programs, options, script.diagnostics);
  script.model = check(script.programs, options, script.diagnostics);
  if (script.model) units::check_units(script.programs, units, *script.model, script.diagnostics);
  if (script.diagnostics.has_errors()) script.model.reset();
  if (!script.model) {
    propose_imports(script);
    return exit_script;
  }
  if (settings_.threads) script.model->options.threads = *settings_.threads;
  script.plan = lower(*script.model);
  warn_of_poles();
  if (settings_.keep_fields) shown = shown_of(*script.plan, *script.model);
  if (settings_.solver) script.plan->options.solver = *settings_.solver;
  if (settings_.factor) script.plan->options.factor = *settings_.factor;
  if (settings_.all_unknowns) script.plan->options.proportional_path = false;
  if (settings_.both_sides) script.plan->options.jumps_as_unknowns = false;
  return exit_ok;
}

void Session::warn_of_poles() {
  const solver::Problem& problem = script.plan->problem;
  if (problem.time.grid.size() < 2) return;
  for (const solver::LoadTerm& load : problem.loads)
    if (const auto pole = pole_of(load, problem.time.grid))
      script.diagnostics.add(
          diagnose("W0108", span_of(script, load.origin),
                   fmt::format("the load grows like |t - {:.6g}|^-{:.4g}, which has no integral",
                               pole->at, pole->exponent))
              .with_help("its values at the grid's times say nothing of what it is between them"));
}

bool Session::compile_variation() {
  if (compile() == exit_ok) return true;
  const auto missing = solver::FailureKind::missing_file;
  for (const Diagnostic& diagnostic : script.diagnostics.items())
    if (diagnostic.code == ending_of(missing).code)
      throw solver::Failure(missing, {}, diagnostic.message);
  return false;
}

Exit Session::discretise(const std::atomic<bool>* stop) {
  return attempt([&] {
    for (const solver::Failure& failure : solver::discretise(*script.plan, discretisation, stop))
      refuse(failure);
    if (!script.diagnostics.has_errors()) {
      report_misfits(script, discretisation);
      report_fine_tables(script, discretisation);
      report_several_values(script, discretisation);
    }
    if (!script.diagnostics.has_errors()) check_materials(script, discretisation);
    if (!script.diagnostics.has_errors()) warn_of_poles_in_space();
  });
}

void Session::warn_of_poles_in_space() {
  const solver::Problem& problem = script.plan->problem;
  for (const solver::LoadTerm& load : problem.loads)
    if (const auto pole = solver::space_pole(problem, discretisation, load))
      script.diagnostics.add(
          diagnose("W0108", span_of(script, load.origin),
                   fmt::format("the load is no functional on V: {}",
                               solver::describe_pole(*pole, discretisation.mesh.dim)))
              .with_help("its values at the points of the mesh say nothing of what it is between "
                         "them, and finer meshes give ever larger ones"));
}

Exit Session::take_first_step() {
  return attempt([&] {
    solver::Timing timing;
    solver::Stepper(*script.plan, discretisation, timing).advance(1);
  });
}

Exit Session::try_out(const std::atomic<bool>* stop, int most_unknowns) {
  const Exit code = discretise(stop);
  const bool stopped = stop != nullptr && *stop;
  if (code != exit_ok || stopped || discretisation.space.n_dofs() > most_unknowns) return code;
  return take_first_step();
}

void Session::solve(const RunRequest& request) {
  const bool shows = !request.settings.output_folder.empty();
  if (const auto wanted = accuracy_wanted(script, request)) {
    accuracy = solver::reach_accuracy(*script.plan, *wanted, request.settings,
                                      request.tell_accuracy, shows ? &shown : nullptr);
    result = accuracy->run;
    script.plan = accuracy->plan;
  } else if (shows) {
    result = solver::run_shown(*script.plan, discretisation, request.settings, shown, &result);
  } else {
    result = solver::run(*script.plan, discretisation, request.settings, &result);
  }
  result.script = script.path;
}

Exit Session::run(const RunRequest& request) {
  return attempt([&] {
    try {
      solve(request);
    } catch (const solver::AccuracyFailure& failure) {
      accuracy = failure.so_far;
      throw;
    }
  });
}

Exit Session::refuse(const solver::Failure& failure) {
  const Ending ending = ending_of(failure.kind);
  warn(ending.code, failure, failure.origin);
  return ending.exit;
}

void Session::warn(const char* code, const solver::Failure& failure, solver::Origin origin) {
  script.diagnostics.add(diagnose(code, span_of(script, origin), failure.what())
                             .with_help(settings_.words.help_for(failure)));
}

} // namespace hvi::lang
