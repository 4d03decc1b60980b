// hvi-run fmt, dump, explain, params and mesh: everything that solves nothing.
#include "lang/check/mesh_findings.hpp"
#include "lang/cli/commands.hpp"
#include "lang/cli/example_calls.hpp"
#include "lang/cli/outputs.hpp"
#include "lang/cli/say.hpp"
#include "lang/diag/catalogue.hpp"
#include "lang/diag/render.hpp"
#include "lang/diag/unreadable.hpp"
#include "lang/editor/server.hpp"
#include "lang/mesh_picture.hpp"
#include "lang/syntax/lexer.hpp"
#include "lang/syntax/print.hpp"
#include "lang/units/units.hpp"
#include "solver/mesh/gmsh_module.hpp"
#include "solver/mesh/mesh.hpp"
#include "solver/mesh/read_msh.hpp"
#include "solver/output/file.hpp"

#include <fmt/format.h>

#include <unistd.h>

#include <cstdio>
#include <filesystem>

namespace hvi::lang {

namespace {

void tell_help(const std::string& help) {
  if (!help.empty()) tell("  = help: {}\n", help);
}

bool rewritten(const std::string& path, const std::string& text) {
  try {
    solver::rewrite_file(path, text);
    return true;
  } catch (const solver::Failure& failure) {
    // Not the code of results: it is the user's own file.
    tell("error[E0610]: {}\n  = help: {}\n", failure.what(), option_words().help_for(failure));
    return false;
  }
}

void tell_findings(const solver::Mesh& mesh, const solver::Straightening& lost) {
  auto found = straightened_cells(mesh, lost);
  for (const MeshFinding& f : misfits(mesh)) found.push_back(f);
  const auto all = solver::measure_pieces(mesh, solver::pieces_of(mesh));
  if (all.size() > 1) found.push_back(pieces(all, {}, mesh.dim));
  for (const MeshFinding& f : found)
    tell("warning[{}]: {}\n  = help: {}\n", f.code, f.message, f.help);
}

} // namespace

int format_command(const std::vector<std::string>& paths, bool only_check) {
  int code = exit_ok;
  for (const std::string& path : paths) {
    Script script;
    script.path = path;
    auto text = read_text(path);
    if (!text) {
      const Ending ending = ending_of(solver::FailureKind::missing_file);
      tell("error[{}]: {}\n", ending.code, why_unreadable(path, path));
      tell_help(meant_file("", path));
      code = ending.exit;
      continue;
    }
    const int id = script.sources.add(path, *text);
    auto formatted = format(script.sources.file(id), script.diagnostics);
    if (!formatted) {
      show_diagnostics(script, {});
      code = exit_script;
    } else if (*formatted != *text) {
      if (only_check) {
        say("{}: not formatted\n", path);
        code = exit_expectation;
      } else if (!rewritten(path, *formatted)) {
        code = exit_solve;
      }
    }
  }
  return code;
}

int dump_command(const std::string& path, const std::string& phase, const Options& options) {
  Session session(path, compile_settings(options));
  const bool syntax = phase == "tokens" || phase == "ast";
  const Exit code = syntax ? session.parse() : session.compile();
  const Script& script = session.script;
  show_diagnostics(script, options);
  if (code != exit_ok) return code;
  const SourceFile& source = script.sources.file(0);
  std::string text;
  if (phase == "tokens") {
    Diagnostics none;
    text = print_tokens(source, lex(source, none));
  } else if (phase == "ast") {
    text = print_ast(script.programs[0], &source);
  } else if (phase == "model") {
    text = to_string(*script.model);
  } else if (phase == "units") {
    for (const std::string& one : units::signatures(script.programs, *script.model))
      text += one + "\n";
  } else {
    text = to_string(*script.plan);
  }
  std::fputs(text.c_str(), stdout);
  return exit_ok;
}

int explain_command(const std::string& code) {
  if (code.empty()) {
    std::fputs(catalogue_markdown(example_calls()).c_str(), stdout);
    return exit_ok;
  }
  const auto text = explain(code, example_calls());
  if (!text) {
    tell("hvi-run: there is no diagnostic `{}`; see docs/diagnostics.md\n", code);
    return exit_usage;
  }
  std::fputs(text->c_str(), stdout);
  return exit_ok;
}

int params_command(const std::string& path, const Options& options) {
  Session session(path, compile_settings(options));
  const Exit code = session.compile();
  show_diagnostics(session.script, options);
  if (code != exit_ok) return code;
  for (const ModelParam& p : session.script.model->params) {
    const auto* number = std::get_if<double>(&p.value);
    const std::string unit = p.unit.empty() ? "" : " [" + p.unit + "]";
    say("{} = {}{}{} ({}){}\n", p.name,
        number ? fmt::format("{}", p.as_declared(*number)) + unit : std::get<1>(p.value),
        p.range.empty() ? "" : " in " + p.range, p.range.empty() ? "" : unit,
        number ? "number" : "word", p.doc.empty() ? "" : "  " + p.doc);
  }
  return exit_ok;
}

int serve_editor_command() {
  return serve_editor(STDIN_FILENO, STDOUT_FILENO, compile_settings({}), version);
}

namespace {

/// The mesh of a script with its parts; drawn into SCRIPT_mesh.png and .svg.
int mesh_of_script(const std::string& path, const Options& options) {
  HeldOutputs outputs;
  Session session(path, compile_settings(options));
  Exit code = session.compile();
  std::vector<std::string> pictures;
  if (code == exit_ok) {
    for (const char* kind : {"_mesh.png", "_mesh.svg"})
      pictures.push_back(session.script.model->title + kind);
    code = outputs.take(outputs_in(options.output_folder, pictures, options), options, session);
  }
  if (code == exit_ok) code = session.discretise();
  if (code == exit_ok) {
    const std::string text = solver::describe_mesh(session.discretisation.mesh) +
                             describe_parts(session.script, session.discretisation);
    std::fputs(text.c_str(), stdout);
  }
  if (code == exit_ok)
    code = session.attempt([&] {
      for (const std::string& name : pictures) {
        const auto picture = std::filesystem::path(options.output_folder) / name;
        draw_mesh(session.script, session.discretisation, picture);
        say("drawn: {}\n", picture.string());
      }
    });
  show_diagnostics(session.script, options);
  return code;
}

} // namespace

int mesh_command(const std::string& path, const Options& options) {
  try {
    if (std::filesystem::path(path).extension() == ".hvi") return mesh_of_script(path, options);
    const bool geo = std::filesystem::path(path).extension() == ".geo";
    if (geo && !options.allow_geo) {
      const Ending ending = ending_of(solver::FailureKind::unasked_geometry);
      tell("error[{}]: a `.geo` file can run programs; allow it with --allow-geo\n", ending.code);
      return ending.exit;
    }
    solver::Straightening lost;
    const solver::Mesh mesh =
        geo ? solver::mesh_geo_file(path, &lost) : solver::read_msh(path, &lost);
    std::fputs(solver::describe_mesh(mesh).c_str(), stdout);
    tell_findings(mesh, lost);
    return exit_ok;
  } catch (const solver::Failure& failure) {
    const Ending ending = ending_of(failure.kind);
    tell("error[{}]: {}\n", ending.code, failure.what());
    tell_help(failure.help.empty() ? meant_file("", path) : failure.help);
    return ending.exit;
  }
}

} // namespace hvi::lang
