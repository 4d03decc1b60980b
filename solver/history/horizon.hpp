// The failure of a memory that was made for an earlier end time and cannot go on to a later one.
#pragma once

#include "solver/common/failure.hpp"

namespace hvi::solver {

/// The memory cannot go on beyond the end it was made for within its tolerance.
struct HorizonFailure : Failure {
  using Failure::Failure;
};

} // namespace hvi::solver
