// Solves of corrections that read a factor in reduced precision where that is enough.
#pragma once

#include "solver/linear/correction_solves.hpp"

#include <memory>

namespace hvi::solver {

/// Triangular solves are bound by reading the factor. One matrix of a run has its factor stored
/// once more with fewer bits an entry (rounded_factor.hpp), which halves that where guesses are so
/// good that one correction is enough. `laws`: laws act on the contact unknowns.
std::unique_ptr<CorrectionSolves> mixed_solves(double tolerance, bool laws);

} // namespace hvi::solver
