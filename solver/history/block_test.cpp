// The test of the moment tree. Evidence, not proof: the error is sampled at times that grow
// geometrically from now on and at times when the narrowest features of the kernel pass through the
// block. A block that a kink will pass through later is refused.
#include "solver/history/block_test.hpp"

#include "solver/history/kernel_samples.hpp"
#include "solver/history/traits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

constexpr std::size_t most_features = 12;
constexpr double usual_blocks = 64;

} // namespace

BlockTest::BlockTest(const PreparedKernel& kernel, const ChebyshevMoments& moments,
                     const HistoryOptions& options)
    : kernel_(kernel), moments_(moments), tolerance_(options.tolerance),
      shortest_(options.shortest_step) {}

void BlockTest::extend(double t0, double horizon) {
  horizon_ = horizon;
  norm_ = std::max(norm_, memory_norm(kernel_.spec.expression, kernel_.traits, t0, horizon));
  features_.clear();
  if (kernel_.traits.convolution) find_features(shortest_ > 0 ? shortest_ : 1e-6 * horizon);
}

/// The narrowest panels of an adaptive sampling, compared with their distance to lag 0.
void BlockTest::find_features(double shortest) {
  if (shortest >= horizon_) return;
  const auto samples = sample_kernel(kernel_, shortest, horizon_, tolerance_, 20000);
  if (!samples) return;                          // fast everywhere: the geometric times see it
  std::vector<std::pair<double, double>> panels; // relative length, middle
  for (std::size_t i = 0; i + 1 < samples->panel_ends.size(); ++i) {
    const double a = samples->panel_ends[i], b = samples->panel_ends[i + 1];
    panels.emplace_back((b - a) / b, 0.5 * (a + b));
  }
  std::sort(panels.begin(), panels.end());
  for (std::size_t i = 0; i < std::min(most_features, panels.size()); ++i) {
    features_.push_back(panels[i].second);
  }
}

std::vector<double> BlockTest::future_times(const TimeBlock& block, double t0, double now) const {
  std::vector<double> times{now};
  const double end = std::max(t0 + horizon_, now);
  const double first = std::max(0.25 * (block.b - block.a), 0.1 * (now - block.b));
  for (double ahead = first; now + ahead < end; ahead *= 1.6) times.push_back(now + ahead);
  times.push_back(end);
  const auto through = [&](double lag) { // the feature passes the block at three places
    for (const double x : {0.2, 0.5, 0.8}) {
      const double t = block.a + x * (block.b - block.a) + lag;
      if (t > now && t < end) times.push_back(t);
    }
  };
  for (const double lag : features_) through(lag);
  return times;
}

double BlockTest::error(const TimeBlock& block, double t0, double now) const {
  if (norm_ <= 0) return 0;
  double worst = 0;
  for (const double t : future_times(block, t0, now)) {
    const double e = moments_.interpolation_error(kernel_.function, block, t);
    if (std::isnan(e)) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, e);
  }
  return worst * (block.b - block.a) / norm_;
}

/// Its part of the time, or one of the usual number of blocks: half the tolerance each.
double BlockTest::allowed(const TimeBlock& block) const {
  return 0.5 * tolerance_ * std::max((block.b - block.a) / horizon_, 1 / usual_blocks);
}

std::optional<double> BlockTest::passes(const TimeBlock& block, double t0, double now) const {
  // A kink at a larger lag passes through the block sooner or later, wherever the samples are.
  const auto& kinks = kernel_.traits.breaks;
  if (!kinks.empty() && kinks.back() > now - block.b) return std::nullopt;
  // The cheap times first: most blocks that fail do so at the present time.
  const double at_once = moments_.interpolation_error(kernel_.function, block, now);
  if (!(at_once * (block.b - block.a) <= allowed(block) * norm_)) return std::nullopt;
  const double e = error(block, t0, now);
  if (!(e <= allowed(block))) return std::nullopt;
  return e;
}

} // namespace hvi::solver
