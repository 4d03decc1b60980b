// Numbers that are none: beyond every other, and unknown.
#pragma once

#include <limits>

namespace hvi::solver {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

} // namespace hvi::solver
