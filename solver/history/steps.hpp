// The steps of a time grid: rounding of t_n - t_{n-1} taken out, so that equal steps are equal.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
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

/// The accepted steps: their names, and whether all were equal so far.
class AcceptedSteps {
public:
  explicit AcceptedSteps(double expected_step = 0) : names_(expected_step) {}
  void start(double t0) { state_ = {t0, t0, 0, 0, 1}; }
  /// Name of the step from the last accepted time to t_new.
  double step_to(double t_new) const { return names_.find(state_.now, t_new); }
  double now() const { return state_.now; }
  double start_time() const { return state_.start; }
  std::int64_t count() const { return state_.count; } ///< of accepted steps
  /// The step of all intervals up to t_new, a time `ahead` steps after the next one, if they are
  /// equal.
  std::optional<double> common_step(double t_new, std::size_t ahead = 0) const {
    if (state_.count == 0 || !state_.uniform) return std::nullopt;
    const double before = state_.now + static_cast<double>(ahead) * state_.step;
    if (names_.find(before, t_new) != state_.step) return std::nullopt;
    return state_.step;
  }
  /// Accepts t_new and returns the name of its step.
  double accept(double t_new) {
    const double k = step_to(t_new);
    names_.remember(k);
    if (state_.count == 0) state_.step = k;
    ++state_.count;
    // Equal steps, and no drift from rounding them: lag indices then stand for the true lags.
    const double expected = state_.start + static_cast<double>(state_.count) * state_.step;
    const double ulp =
        std::numeric_limits<double>::epsilon() * std::max(std::abs(state_.start), std::abs(t_new));
    state_.uniform = state_.uniform && k == state_.step && std::abs(t_new - expected) <= 16 * ulp;
    state_.now = t_new;
    return k;
  }
  template <class Writer>
  void save(Writer& w) const {
    w.put(state_.start);
    w.put(state_.now);
    w.put(state_.step);
    w.put(state_.count);
    w.put(state_.uniform);
    w.put(names_.known());
  }
  template <class Reader>
  void restore(Reader& r) {
    state_.start = r.get_finite();
    state_.now = r.get_finite();
    state_.step = r.get_finite();
    state_.count = r.template get_between<std::int64_t>(0, std::int64_t{1} << 40);
    state_.uniform = r.template get<std::uint8_t>() != 0;
    names_.set_known(r.get_numbers());
    if (state_.now < state_.start) r.fail("is inconsistent");
  }

private:
  struct State {
    double start = 0, now = 0, step = 0;
    std::int64_t count = 0;
    std::uint8_t uniform = 1;
  };
  StepNames names_;
  State state_;
};

} // namespace hvi::solver
