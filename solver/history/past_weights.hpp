// Exact weights of all raw intervals at one time.
#pragma once

#include "solver/history/prepared.hpp"
#include "solver/history/steps.hpp"

#include <map>
#include <optional>
#include <span>
#include <vector>

namespace hvi::solver {

/// On a uniform grid a convolution kernel has one weight per lag index, computed once. Otherwise:
/// 7-point panels evaluated together, each checked by its embedded 3-point rule; what fails gets 15
/// points, and what fails again, touches lag 0, holds a break or is longer than the kernel's finest
/// features there is done adaptively.
class PastWeights {
public:
  /// Weights of (times[j], times[j+1]) at t. `step`: of all steps up to t, if they are equal; then
  /// `steps_after` of them lie between times.back() and the last one.
  std::span<const Moments> operator()(const PreparedKernel& kernel, std::optional<double> step,
                                      double t, std::span<const double> times,
                                      std::size_t steps_after = 0);
  void reset() { by_index_.clear(), edges_.clear(); }

private:
  struct Interval {
    double low, high; ///< lags
  };
  void by_index(const PreparedKernel& kernel, double step, std::size_t count);
  void integrate(const PreparedKernel& kernel, double t, std::span<Moments> out);
  void done_exactly(const PreparedKernel& kernel, double t, std::span<Moments> out);
  const std::vector<double>& edges(const PreparedKernel& kernel, double t, const Interval& i);
  bool resolved(const PreparedKernel& kernel, double t, const Interval& interval);
  template <unsigned Points>
  void try_panels(const PreparedKernel& kernel, double t, std::span<Moments> out);

  std::vector<Moments> by_index_, weights_;
  std::vector<Interval> intervals_;
  std::vector<std::size_t> open_; ///< intervals without weight so far
  std::vector<double> lags_, values_;
  /// Ends of panels on which the kernel is proved to be resolved: of a convolution up to lag 2^k,
  /// by k, else (0) of the intervals asked for.
  std::map<int, std::vector<double>> edges_;
};

/// Weights of the values at the ends of the intervals. Order 0: u_j on (t_{j-1}, t_j]. Order 1:
/// u = u_j (1 - x) + u_{j-1} x, one weight more than intervals.
void put_node_weights(std::span<const Moments> intervals, int order, std::vector<double>& nodes);

} // namespace hvi::solver
