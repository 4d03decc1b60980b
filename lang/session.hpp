// The whole pipeline in one place: read this file first.
//
//   file -> SourceMap -> lexer/parser -> ast::Program -> checker -> Model -> lower -> plan::Plan
//        |---------------------------- Session::compile -----------------------------------------|
//        -> Discretisation -> RunResult -> table, files, JSON
//        |-- discretise --|--- run ---|
//
// Every command of the command line (lang/cli) is a session that stops where the command has what
// it needs: `params` after compile, `check` and `plan` after discretise, `run` and `test` after
// run.
#pragma once

#include "lang/check/check.hpp"
#include "lang/diag/failures.hpp"
#include "lang/diag/words.hpp"
#include "lang/script.hpp"
#include "solver/results/shown.hpp"
#include "solver/study/accuracy.hpp"
#include "solver/time/run.hpp"

#include <atomic>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>

namespace hvi::lang {

/// What decides the plan, besides the script.
struct CompileSettings {
  std::map<std::string, std::string> defines; ///< parameter -> value
  bool allow_geo = false;                     ///< geometry files may be read: they can run programs
  bool keep_fields = false;  ///< the result holds the unknowns and the stress of many times
  bool all_unknowns = false; ///< in every step, also where the contact unknowns would do
  bool both_sides = false;   ///< of pairs: their contact unknowns, also where jumps would do
  std::optional<solver::LinearSolver> solver = {};  ///< whatever the script says
  std::optional<solver::FactorEntries> factor = {}; ///< the same
  std::optional<int> threads;
  Words words;
  std::function<void(const NameFacts&)> on_name = nullptr; ///< of each declaration, for editors
};

/// What decides a run, besides the plan.
struct RunRequest {
  solver::RunSettings settings;
  double accuracy = 0.0; ///< wanted relative error; 0: the script's, or none
  std::string accuracy_of;
  bool as_written = false; ///< for an accuracy: keep element, scheme and grading
  double budget = 0.0;     ///< CPU seconds a run for an accuracy may be predicted to take
  std::function<void(const std::string&)> tell_accuracy = [](const std::string&) {};
};

/// A script and what has become of it so far. Each phase needs the one before it. It returns
/// exit_ok, or the exit code that the program ends with; the diagnostics then say why.
class Session {
public:
  Session(std::string path, CompileSettings settings, std::optional<std::string> text = {});
  Session(const Session&) = delete; // results point into the discretisation
  Session& operator=(const Session&) = delete;

  /// File -> syntax trees.
  Exit parse();
  /// File -> plan.
  Exit compile();
  /// The same for a script that compiled before, with other numbers: false where these give no
  /// plan. Throws Failure(missing_file) where a file cannot be read any more, which says nothing of
  /// the numbers.
  bool compile_variation();
  /// Plan -> mesh, parts and space, with the mistakes that only show there: groups that do not
  /// exist, pieces that nothing holds, materials that are not elliptic. `stop` ends the adaptation
  /// of a mesh.
  Exit discretise(const std::atomic<bool>* stop = nullptr);
  /// The matrix of the first step, which tells whether all forms together determine the unknown.
  Exit take_first_step();
  /// Both: what `check` and editors look for behind the plan. A first step of more than
  /// `most_unknowns` is not taken.
  Exit try_out(const std::atomic<bool>* stop = nullptr,
               int most_unknowns = std::numeric_limits<int>::max());
  /// All steps, of the plan or, where an accuracy is wanted, of the cheapest plan that has it. What
  /// is known where a run fails is in `result` and `accuracy`.
  Exit run(const RunRequest& request);

  /// Does something that may throw a Failure, which becomes a diagnostic at the line of its origin.
  template <class Phase>
  Exit attempt(const Phase& phase) {
    try {
      phase();
      return script.diagnostics.has_errors() ? exit_script : exit_ok;
    } catch (const solver::Failure& failure) {
      return refuse(failure);
    }
  }
  /// Adds a failure as a diagnostic at the line its origin stands for: the exit code that belongs
  /// to it.
  Exit refuse(const solver::Failure& failure);
  /// A failure that is only a warning here, at the line of `origin`.
  void warn(const char* code, const solver::Failure& failure, solver::Origin origin);

  /// The discretisation of the result.
  const solver::Discretisation& last_discretisation() const {
    return accuracy ? *accuracy->discretisation : discretisation;
  }

  Script script;
  solver::Discretisation discretisation;
  solver::RunResult result;
  solver::Shown shown;                            ///< of the result, where files are written
  std::optional<solver::AccuracyResult> accuracy; ///< where one was wanted

private:
  void solve(const RunRequest& request);
  /// Of loads within the time of the run and on their parts, W0108.
  void warn_of_poles();
  void warn_of_poles_in_space();

  CompileSettings settings_;
};

} // namespace hvi::lang
