// Which solution a step follows where the inequality has several.
#pragma once

namespace hvi::solver {

/// `continuing`: the branch that continues the last step; `release`: let go at downward jumps at
/// once; `least_energy`: the branch of least energy among those found.
enum class Branch { continuing, release, least_energy };

} // namespace hvi::solver
