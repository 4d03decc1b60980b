// What the entries of a factor are.
#pragma once

namespace hvi::solver {

/// A factor of singles takes half the memory and half the time of one of doubles, and knows seven
/// digits of a solution less the growth of the matrix, which corrections of the solution mend.
enum class FactorEntries { doubles, singles };

} // namespace hvi::solver
