// How long a run still takes, from the steps that it has taken.
#pragma once

#include <utility>
#include <vector>

namespace hvi::lang {

/// Steps may get slower, as where each sums over the ones before it: the time of a step is taken to
/// be affine in its number, as the first and the second half of those taken say, and not to fall.
class TimeLeft {
public:
  /// `seconds` from the beginning, after `step` steps; both grow.
  void note(int step, double seconds);
  /// Seconds for the steps that are left of so many; 0 before the first.
  double estimate(int steps) const;

private:
  double seconds_at(int step) const;

  std::vector<std::pair<int, double>> noted_{{0, 0.0}};
};

} // namespace hvi::lang
