// What a memory says that was made for an earlier end time than it is asked to go on to.
#pragma once

#include "solver/common/failure.hpp"

namespace hvi::solver {

/// The memory cannot go on beyond the end it was made for within its tolerance.
struct HorizonFailure : Failure {
  using Failure::Failure;
};

} // namespace hvi::solver
