// What the first process tells the others. Each call of bridge.h that all have to make is announced
// to them, and they make it too.
#pragma once

#include "solver/linear/petsc/tasks.hpp"

namespace hvi::petsc_module {

struct Command {
  enum What : int { open, changed, free, laws, solve, close, task, end };
  What what = end;
  int solver = 0; ///< its number
  int number = 0; ///< open and laws: symmetric? free: columns; task: the errand; end: the exit code
  double reduction = 0.0; ///< solve
  /// Open: K is dealt out so; 0: the first process has all of it.
  unsigned long long set = 0;
  int matrix = 0;
};

/// Of the first process. Throws PetscFailure where `give_up` was called.
void announce(const Command& command);

/// The same; false instead.
bool announced(const Command& command);

/// A call failed here, while the others may wait in it: no other call can follow.
void give_up();

/// The others end with this exit code, and so does this process. Returns solvers that were opened.
int dismiss(int exit_code);

/// Of every other process: makes the calls until the first one ends, and does errands by `helper`.
/// Returns the exit code of the first one.
int serve(const HviPetscHelper& helper);

} // namespace hvi::petsc_module
