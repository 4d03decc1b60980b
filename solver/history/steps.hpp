// The steps of a time grid: rounding of t_n - t_{n-1} taken out, so that equal steps are equal.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace hvi::solver {

/// Recognises steps seen before. A step is known up to the rounding of its two times only; equal
/// steps must give equal bits so that weights are computed once.
class StepNames {
public:
  explicit StepNames(double expected = 0) {
    if (expected > 0) known_.push_back(expected);
  }
  /// The step from t_before to t_new, or the known one that it is within rounding.
  double find(double t_before, double t_new) const {
    const double k = t_new - t_before;
    const double ulps =
        4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t_before), std::abs(t_new));
    for (const double known : known_) {
      if (std::abs(k - known) <= ulps) return known;
    }
    return k;
  }
  /// Of an accepted step only, so that a rejected one leaves no trace.
  void remember(double k) {
    if (std::find(known_.begin(), known_.end(), k) != known_.end()) return;
    if (known_.size() >= capacity) known_.erase(known_.begin() + 1);
    known_.push_back(k);
  }
  const std::vector<double>& known() const { return known_; }
  void set_known(std::vector<double> known) { known_ = std::move(known); }

private:
  static constexpr std::size_t capacity = 16;
  std::vector<double> known_;
};

} // namespace hvi::solver
