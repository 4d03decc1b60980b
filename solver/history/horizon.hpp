// Where a memory that was made for an earlier end time cannot go on to a later one.
#pragma once

#include "solver/common/failure.hpp"

#include <string>

namespace hvi::solver {

/// Beyond the end it was made for a memory is not within its tolerance: a run that continues it
/// starts again from its first step.
struct HorizonEnd {
  Origin origin;
  std::string said, help;
};

} // namespace hvi::solver
