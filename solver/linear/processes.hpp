// Several processes of one run, which mpirun started: the first one runs the program, and the
// others take their part in iterations (petsc/commands.hpp) and in what it deals out.
#pragma once

#include "solver/linear/own_rows.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::solver {

struct Processes {
  int rank = 0, count = 1;
  bool several() const { return count > 1; }
};

/// What a message asks for.
enum class Errand : int {
  write_piece, ///< write_piece (results/piece_files.hpp)
  matrices     ///< OwnMatrices::answer (discrete/own_matrices.hpp)
};

/// The answer to a message. Makes its failures a part of the answer: only memory may be missing.
using Task = std::function<std::string(std::string_view message)>;

/// What another process does for the first one.
class Helper {
public:
  virtual ~Helper() = default;
  /// As a Task.
  virtual std::string answer(Errand errand, std::string_view message) = 0;
  /// Its rows of a matrix (OwnMatrices::placed).
  virtual RowArrays rows(std::uint64_t set, int matrix) const = 0;
};

/// As the environment of the launcher says; one where there is none. MPI is not asked.
Processes started_processes();

/// The first one, before all else. Throws Failure where the module cannot be loaded, or where MPI
/// finds other processes.
void lead(const Processes& processes);

/// How many processes there are while this one leads; else 1.
int processes_led();

/// The first one at its end. Returns how many iterative solvers there were.
int dismiss(int exit_code);

/// Any other process: `helper` answers what `deal_out` of the first one sends. Returns the exit
/// code of the first one; 0 where the module cannot be loaded, which the first one says.
int serve(const Processes& processes, Helper& helper);

/// The first one after `lead`: sends a message to every process and does the first of them itself,
/// by `task`. The answers, in the order of the processes. Throws Failure where they cannot be
/// reached.
std::vector<std::string> deal_out(Errand errand, std::span<const std::string> messages,
                                  const Task& task);

} // namespace hvi::solver
