// May a block of time be read through its moments from now on? Asked at sampled future times.
#pragma once

#include "solver/history/moments.hpp"
#include "solver/history/prepared.hpp"

#include <optional>
#include <vector>

namespace hvi::solver {

class BlockTest {
public:
  BlockTest(const PreparedKernel& kernel, const ChebyshevMoments& moments,
            const HistoryOptions& options);
  /// Called when the run goes beyond the horizon known so far (or has none).
  void extend(double t0, double horizon);
  double horizon() const { return horizon_; }
  double norm() const { return norm_; }

  /// Largest error of the block's share of the memory at sampled times from `now` on, relative to
  /// norm * max|u|; none when it is above what a block may have.
  std::optional<double> passes(const TimeBlock& block, double t0, double now) const;
  /// The same number whatever it is (infinite: not finite).
  double error(const TimeBlock& block, double t0, double now) const;

private:
  double allowed(const TimeBlock& block) const;
  std::vector<double> future_times(const TimeBlock& block, double t0, double now) const;
  void find_features(double shortest);

  const PreparedKernel& kernel_;
  const ChebyshevMoments& moments_;
  double tolerance_, shortest_ = 0, horizon_ = 0, norm_ = 0;
  std::vector<double> features_; ///< lags where a convolution kernel varies fastest
};

} // namespace hvi::solver
