// Messages of the first process to each other one, and their answers: work that is no iteration.
// What they say is the program's affair.
#pragma once

#include "solver/linear/petsc/bridge.h"

#include <cstddef>
#include <string>
#include <vector>

namespace hvi::petsc_module {

/// Of the first process, after it was announced: a message for each of the others.
void hand_out(const HviPetscBytes* messages);

/// Of the first process: what each of them answers.
std::vector<std::string> take_in();

/// Of another process: waits for a message and answers it. Throws bad_alloc.
void answer(const HviPetscHelper& helper, int errand);

} // namespace hvi::petsc_module
