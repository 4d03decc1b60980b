// How a run is asked for: where its files go, who listens, what stops it.
#pragma once

#include "solver/linear/sparse.hpp"

#include <atomic>
#include <functional>
#include <string>

namespace hvi::solver {

struct Progress {
  int step, steps, newton;
  double seconds;
};
struct RunSettings {
  std::string output_folder; ///< empty: no files
  std::string name = "result";
  std::function<void(const Progress&)> progress;
  /// Called before the first step with u at the initial time, as a row `from start` has it: given,
  /// or the solution of the static problem. Not of a static problem, nor of a run that is resumed.
  std::function<void(double, const Vector&)> on_start;
  /// Called after every accepted step with (n, t, u, xi of all law points).
  std::function<void(int, double, const Vector&, const Vector&)> on_step;
  /// Called when the run starts again (a memory by another route, for one): what `on_step` has been
  /// told so far is of no run, and its start and steps come anew.
  std::function<void()> on_restart;
  /// Probes are read after every step, not only where a table has a row.
  bool every_value = false;
  /// Told at once when a file cannot be written. The run goes on: see RunResult::unwritten.
  std::function<void(const std::string&)> warn;
  const std::atomic<bool>* stop = nullptr; ///< set by Ctrl-C: ends with Failure(interrupted), or
                                           ///< Failure(suspended) where it saves its state. Heeded
                                           ///< in the middle of a step where no state gets lost
  /// Every so many steps, at the end and on `stop` the state goes to <folder>/<name>.checkpoint;
  /// 0: never. `resume`: goes on from that file when it is there, with the same bits.
  int checkpoint_every = 0;
  bool resume = false;
  /// Which mpirun started and `lead` leads: each writes a piece of a body's fields.
  int processes = 1;
  bool condition =
      false; ///< always fill ForwardError::condition, else where it costs next to nothing
  bool monitors = false; ///< fill RunResult::monitors and write <name>_monitors.csv
};

} // namespace hvi::solver
