// Several processes of one run, which mpirun started: the first one runs the program, and the
// others take their part in iterations (petsc/commands.hpp).
#pragma once

namespace hvi::solver {

struct Processes {
  int rank = 0, count = 1;
  bool several() const { return count > 1; }
};

/// As the environment of the launcher says; one where there is none. MPI is not asked.
Processes started_processes();

/// The first one, before all else. Throws Failure where the module cannot be loaded, or where MPI
/// finds other processes.
void lead(const Processes& processes);

/// The first one at its end. Returns how many iterative solvers there were.
int dismiss(int exit_code);

/// Any other process. Returns the exit code of the first one; 0 where the module cannot be loaded,
/// which the first one says.
int serve(const Processes& processes);

} // namespace hvi::solver
