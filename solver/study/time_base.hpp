// Grids of time that follow the data and the solution: a base of unequal intervals, each of which a
// setting cuts into the same number of equal steps.
#pragma once

#include "solver/study/data_times.hpp"

#include <vector>

namespace hvi::solver {

struct TimeBase {
  std::vector<double> grid; ///< the base t_0 < ... < T; of a uniform or graded one, the script's
  /// t_n = t_0 + T (n/N)^power with any number of steps; 0: the intervals of `grid`, cut alike.
  double power = 1.0;
  int coarsest = 4; ///< fewest steps
  int unit = 2;     ///< runs of multiples of this have the times of half as many steps among theirs
};

/// The grid as the script has it: uniform, power-graded or listed.
TimeBase script_base(const TimeSpec& time);

/// The script's grid made to see the data: the breaks are among its times, and neighbouring
/// intervals differ by a factor two at most. Where something jumps, or the slope of an imposed
/// value, two times very close to each other stand for its two sides, and the steps after them
/// begin anew (time_grid.hpp). Data without breaks that vary evenly leave a uniform grid, with
/// enough steps.
TimeBase data_base(const TimeSpec& time, const DataTimes& data);

/// The base with interval i cut into 2^halvings[i] parts, and as many more as it takes to keep
/// neighbours within a factor two.
TimeBase refined_base(const TimeBase& base, const std::vector<int>& halvings);

/// Is interval i of the base one that stands for a jump?
bool is_jump(const TimeBase& base, std::size_t i);

} // namespace hvi::solver
