// Which solution a step follows where the inequality has several.
#pragma once

namespace hvi::solver {

/// `continuing`: the branch that continues the last step; `release`: let go at downward jumps at
/// once; `least_energy`: the branch of least energy among those found.
enum class Branch { continuing, release, least_energy };

/// What a report says of the choice.
constexpr const char* sentence(Branch branch) {
  switch (branch) {
  case Branch::continuing:
    return "the branch that continues the last step is followed";
  case Branch::release:
    return "the released branch is followed";
  case Branch::least_energy:
    break;
  }
  return "of the branches found the one of least energy is followed";
}

} // namespace hvi::solver
