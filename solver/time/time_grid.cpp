// Steps of a time grid, and the difference formula of each; see time_grid.hpp.
#include "solver/time/time_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace hvi::solver {
namespace {

constexpr int most_factors = 4;

/// The increment of a step so much shorter than the next says nothing of the slope there: such
/// steps stand for jumps of the data, and BDF2 would carry the jump on.
constexpr double begins_anew = 100.0;

} // namespace

TimeGrid::TimeGrid(const TimeSpec& spec)
    : is_static_(spec.is_static), scheme_(spec.scheme), times_(spec.grid) {
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
    if (distinct.size() == 2 * most_factors) distinct.erase(distinct.begin());
    distinct.push_back(lengths_[n]);
  }
  useful_factors_ = count_factors();
}

double TimeGrid::rounding(int n) const {
  if (is_static_) return 0.0;
  const double size = std::max(std::abs(times_[n]), std::abs(times_[n - 1]));
  return 8 * std::numeric_limits<double>::epsilon() * (1 + size / lengths_[n]);
}

double TimeGrid::rate(int n) const {
  if (!second_order(n) || ratio(n) > begins_anew) return 1.0 / lengths_[n];
  const double w = ratio(n);
  return (1 + 2 * w) / ((1 + w) * lengths_[n]);
}

double TimeGrid::carry(int n) const {
  if (!second_order(n) || ratio(n) > begins_anew) return 0.0;
  const double w = ratio(n);
  return w * w / ((1 + w) * lengths_[n]);
}

double TimeGrid::shortest() const {
  return *std::min_element(lengths_.begin() + 1, lengths_.end());
}

int TimeGrid::count_factors() const {
  std::set<double> seen;
  bool comes_back = false;
  for (int n = 1; n <= steps(); ++n) {
    const bool fresh = seen.insert(rate(n)).second;
    comes_back = comes_back || (!fresh && rate(n) != rate(n - 1 > 0 ? n - 1 : n));
  }
  return comes_back ? std::min(most_factors, static_cast<int>(seen.size())) : 1;
}

} // namespace hvi::solver
