// See time_left.hpp. Used by the progress line of a run.
#include "lang/cli/time_left.hpp"

#include <algorithm>
#include <iterator>

namespace hvi::lang {

void TimeLeft::note(int step, double seconds) {
  if (step > noted_.back().first) noted_.emplace_back(step, seconds);
}

/// Affine between the steps that were noted.
double TimeLeft::seconds_at(int step) const {
  const auto after = std::ranges::lower_bound(noted_, step, {}, &std::pair<int, double>::first);
  if (after == noted_.begin()) return after->second;
  const auto before = std::prev(after);
  const double share =
      static_cast<double>(step - before->first) / static_cast<double>(after->first - before->first);
  return before->second + share * (after->second - before->second);
}

double TimeLeft::estimate(int steps) const {
  const auto [done, seconds] = noted_.back();
  if (done == 0 || steps <= done) return 0.0;
  const double left = steps - done, all = done, half = done / 2;
  if (half == 0.0) return left * seconds / all;
  const double at_half = seconds_at(done / 2);
  // Times of a step: means of the two halves, at the steps in their middle.
  const double first = at_half / half, second = (seconds - at_half) / (all - half);
  const double growth = std::max(second - first, 0.0) / (all / 2.0);
  const double middle_of_second = (half + all) / 2.0, middle_of_left = (all + steps) / 2.0;
  return left * (second + growth * (middle_of_left - middle_of_second));
}

} // namespace hvi::lang
