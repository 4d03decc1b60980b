// How often a run has started again and why, and the state a run is resumed from. Used by run.cpp.
#pragma once

#include "solver/discrete/chosen_solver.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/linear/vector_stream.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/run_settings.hpp"
#include "solver/step/step_result.hpp"
#include "solver/time/checkpoint.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace hvi::solver {

void put_notes(StateWriter& w, const std::vector<StepNote>& notes);
std::vector<StepNote> get_notes(StateReader& r);

/// What earlier tries have changed or chosen so far: the routes of memories, the unknowns of pairs,
/// the linear solver, and the notes on them.
struct Restarts {
  std::vector<int> routes;     ///< by history; -1: the plan's own
  bool checks_at_once = false; ///< a check that was put off has failed before
  bool both_sides = false;     ///< jumps across pairs are no unknowns any more
  bool all_unknowns = false;   ///< steps are not solved on the contact unknowns any more
  bool doubles = false;        ///< the factor is no longer in single precision
  /// Of the state that is gone on from: it has that solver's unknowns.
  std::optional<ChosenSolver> solver;
  std::vector<StepNote> notes;

  void take(const MemoryMistrust& mistrust);
  void take(const HorizonEnd& end);
  void take(const LateCheck&) { checks_at_once = true; }
  void take(const JumpsRefused&) { both_sides = true; }
  void take(const RowsRefused&) { all_unknowns = true; }
  void take(const SinglesRefused&) { doubles = true; }
  /// Throws Failure(limit) where a memory ends before the run does and nothing was `resumed`.
  void take(const Restart& why, bool resumed);
  Plan applied(const Plan& plan) const;
  /// What has changed in a run that has ended well, and which routes its memories took.
  void add_notes(const Plan& plan, RunResult& result) const;

  /// `chosen`: by the run that is saved.
  void save(StateWriter& w, const ChosenSolver& chosen) const;
  /// Throws Failure(bad_checkpoint) where the plan asks for another solver than the saved one.
  void restore(StateReader& r, const Plan& plan);
};

/// Reads a saved state: any error found in it names the file. Throws Failure(bad_checkpoint).
void with_its_name(const std::filesystem::path& file, const std::function<void()>& read);

/// The state to resume from, if that was requested and there is one.
std::optional<std::string> saved_state(const Plan& plan, const Discretisation& discretisation,
                                       const RunSettings& settings);

} // namespace hvi::solver
