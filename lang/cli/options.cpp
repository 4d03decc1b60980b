// The options in what is asked of a session, and in messages, which name none below this folder;
// see options.hpp.
#include "lang/cli/options.hpp"

#include "lang/diag/render.hpp"

#include <cstdio>

namespace hvi::lang {

namespace {

/// What can be done about a failure that brings no help of its own.
std::string help(solver::FailureKind kind) {
  using K = solver::FailureKind;
  switch (kind) {
  case K::unasked_geometry:
    return "mesh it first (`gmsh -2 FILE.geo`), or allow it with --allow-geo";
  case K::out_of_reach:
    return "ask for less, allow more with --budget SECONDS, or grade the mesh toward corners";
  case K::bad_checkpoint:
    return "remove it, or run without --resume, to begin at the first step";
  case K::special_output:
    return "results go to files; `--json -` writes JSON to the standard output, for a pipe of the "
           "shell";
  case K::output_folder:
    return "choose another output folder (-o), or make room and give permission to write there";
  case K::busy_folder:
    return "wait for it, or choose another output folder with -o";
  case K::suspended:
    return "`--resume` goes on from here";
  default:
    return {};
  }
}

} // namespace

const Words& option_words() {
  static const Words words = {
      .define = "-D ",
      .allow_geometry = "allow it with --allow-geo",
      .output_folder = "the output folder (-o DIR)",
      .help = help,
  };
  return words;
}

CompileSettings compile_settings(const Options& options) {
  return {.defines = options.defines,
          .allow_geo = options.allow_geo,
          .all_unknowns = options.full,
          .both_sides = options.both_sides,
          .solver = solver::linear_solver_of(options.solver),
          .factor = solver::factor_entries_of(options.factor),
          .threads = options.threads,
          .words = option_words()};
}

void show_diagnostics(const Script& script, const Options& options) {
  if (script.diagnostics.size() == 0) return;
  RenderOptions render_options;
  render_options.colour = options.colour;
  const std::string text = options.json_diagnostics
                               ? render_json(script.diagnostics, script.sources)
                               : render(script.diagnostics, script.sources, render_options);
  std::fputs(text.c_str(), stderr);
}

} // namespace hvi::lang
