// The whole pipeline in one place: read this file first.
//
//   file -> SourceMap -> lexer/parser -> ast::Program -> checker -> Model -> lower -> plan::Plan
//        -> discretise -> run -> table, files, JSON
#pragma once

#include "lang/check/model.hpp"
#include "lang/diag/diagnostic.hpp"
#include "lang/diag/source.hpp"
#include "lang/syntax/ast.hpp"
#include "solver/plan/plan.hpp"
#include "solver/time/result_json.hpp"
#include "solver/time/run.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

inline constexpr const char* version = HVI_VERSION; ///< CMakeLists.txt has it

/// Exit codes, fixed (docs/language.md, "The command").
enum Exit {
  exit_ok = 0,
  exit_script = 1,
  exit_usage = 2,
  exit_solve = 3,
  exit_hypothesis = 4,
  exit_expectation = 5,
  exit_bug = 70,
  exit_interrupted = 130
};

/// What the command line said.
struct Options {
  std::map<std::string, std::string> defines;
  std::string output_folder;
  std::string json;
  bool quiet = false;
  bool no_files = false;   ///< print only; a JSON that was asked for is written all the same
  bool colour = false;     ///< on stderr
  bool colour_out = false; ///< on stdout
  bool strict = false;
  bool allow_geo = false;
  bool json_diagnostics = false;
  bool script_only = false;
  bool profile = false;
  bool full = false; ///< all unknowns at every step, also where the contact unknowns would do
  int threads = 1;
  int checkpoint = 0; ///< every so many steps; 0: never
  bool resume = false;
  bool monitors = false;
  double accuracy = 0.0; ///< wanted relative error; 0: the script's, or none
  std::string accuracy_of;
  bool as_written = false; ///< for an accuracy: keep element, scheme and grading
  double budget = 3600.0;  ///< CPU seconds a run for an accuracy may be predicted to take
};

/// A script on its way through the phases; each stage is kept, so that it can be dumped.
struct Script {
  std::string path;
  std::optional<std::string> text; ///< instead of what the file holds
  SourceMap sources;
  Diagnostics diagnostics;
  std::vector<ast::Program> programs; ///< [0] is the script, then its imports
  std::optional<Model> model;
  std::optional<solver::Plan> plan;
};

/// Reads and parses the script and what it imports.
void parse_script(Script& script);
/// parse, check and lower. False when there are errors (they are in script.diagnostics).
bool compile_script(Script& script, const Options& options);
/// The same for a script that compiled before, with other numbers. Throws Failure(missing_file)
/// where a file cannot be read any more, which says nothing of the numbers.
bool compile_variation(Script& script, const Options& options);
/// Adds an engine's failure as a diagnostic at the line its origin stands for.
void add_failure(Script& script, const solver::Failure& failure);
/// The exit code that belongs to a failure of the engine.
int exit_code(const solver::Failure& failure);
/// Prints the diagnostics to stderr (text or JSON).
void show_diagnostics(const Script& script, const Options& options);
/// Line (from 1) of an origin in the script's own file; 0 when it lies elsewhere.
int line_of(const Script& script, solver::Origin origin);

/// Parameters and lines for the JSON of a script, which must outlive it.
solver::ResultContext json_context(const Script& script);
/// The folder results go to: -o, or one named after the script and the parameters given
/// (outputs.cpp).
std::string output_folder(const Script& script, const Options& options);

/// The commands. Each returns an exit code.
int run_command(const std::string& path, const Options& options);
int check_command(const std::vector<std::string>& paths, const Options& options);
int plan_command(const std::string& path, const Options& options);
int study_command(const std::string& path, const Options& options);
/// How far a model can be trusted: margins, certificates, energies, sensitivity.
int stability_command(const std::string& path, const Options& options);
int test_command(const std::vector<std::string>& paths, const Options& options);
int format_command(const std::vector<std::string>& paths, bool only_check);
int dump_command(const std::string& path, const std::string& phase, const Options& options);
/// One diagnostic; all of them, as Markdown, when no code is given.
int explain_command(const std::string& code);
int params_command(const std::string& path, const Options& options);
int mesh_command(const std::string& path, const Options& options);

} // namespace hvi::lang
