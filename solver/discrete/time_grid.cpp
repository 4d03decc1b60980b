// Times and lengths of steps; see time_grid.hpp.
#include "solver/discrete/time_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

/// Lengths that are compared with the next one.
constexpr std::size_t most_distinct = 8;

} // namespace

TimeGrid::TimeGrid(const TimeSpec& spec) : is_static_(spec.is_static), times_(spec.grid) {
  lengths_.assign(static_cast<std::size_t>(steps()) + 1, 1.0);
  if (is_static_) return;
  std::vector<double> distinct; // of the last few lengths: a graded grid has as many as steps
  for (int n = 1; n <= steps(); ++n) {
    lengths_[n] = times_[n] - times_[n - 1];
    const auto same = std::find_if(distinct.begin(), distinct.end(), [&](double k) {
      return std::abs(k - lengths_[n]) <= rounding(n) * k;
    });
    if (same != distinct.end()) {
      lengths_[n] = *same;
      continue;
    }
    if (distinct.size() == most_distinct) distinct.erase(distinct.begin());
    distinct.push_back(lengths_[n]);
  }
}

double TimeGrid::rounding(int n) const {
  if (is_static_) return 0.0;
  const double size = std::max(std::abs(times_[n]), std::abs(times_[n - 1]));
  return 8 * std::numeric_limits<double>::epsilon() * (1 + size / lengths_[n]);
}

double TimeGrid::shortest() const {
  return *std::min_element(lengths_.begin() + 1, lengths_.end());
}

} // namespace hvi::solver
