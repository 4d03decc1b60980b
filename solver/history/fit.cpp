// The fitted route: a sum of exponentials for lags above a window, raw steps with exact weights
// within the window. The window is the shortest step, or the last kink of the kernel.
#include "solver/common/stream.hpp"
#include "solver/history/exponentials.hpp"
#include "solver/history/horizon.hpp"
#include "solver/history/past_weights.hpp"
#include "solver/history/pole_fit.hpp"
#include "solver/history/routes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace hvi::solver {

namespace {

constexpr std::uint32_t fit_magic = 0x46495431;
/// A fit takes some five exponentials a decade, and time like the fourth power of their number.
constexpr double most_decades = 40.0;

struct SavedTerm {
  Complex factor, rate;
};

class FitHistory final : public History {
public:
  FitHistory(const PreparedKernel& kernel, const FittedSum& sum, std::size_t n,
             const HistoryOptions& options, double window, std::string why)
      : kernel_(kernel), terms_(sum.terms), sum_(sum.terms, false), n_(n), order_(options.order),
        window_(window), tolerance_(options.tolerance), error_(sum.error),
        horizon_(options.horizon), why_(std::move(why)), accepted_(options.shortest_step),
        fields_(n) {
    if (!options.times.empty()) planned_end_ = options.times.back();
  }

  void start(double t0, std::span<const double> u0) override {
    accepted_.start(t0);
    times_.assign(1, t0);
    steps_.clear();
    fields_.clear();
    weights_.reset();
    states_.assign(sum_.state_fields() * n_, 0.0);
    if (order_ == 1) {
      check_field(kernel_, n_, u0.size());
      fields_.push(u0);
    }
  }

  /// Raw steps that have left the window enter the states in the pass that reads them. They left
  /// at an accepted time, so that a shorter step tried next needs none of them back.
  void rhs(double t_new, std::span<double> out) override {
    check_field(kernel_, n_, out.size());
    check_step(kernel_, accepted_.now(), t_new);
    check_horizon(t_new);
    std::fill(out.begin(), out.end(), 0.0);
    while (leaving() > 1) absorb();
    if (leaving() == 1) {
      advance(ahead_of(t_new, 1), out);
    } else {
      prepare(0, ahead_of(t_new, 0));
      read_states(groups_, states_, out);
    }
    put_node_weights(weights_(kernel_, accepted_.common_step(t_new), t_new, times_), order_,
                     node_weights_);
    if (order_ == 1) node_weights_.back() += current(t_new).one;
    reads_ += static_cast<std::int64_t>(node_weights_.size()) +
              static_cast<std::int64_t>(sum_.state_fields());
    add_combination(node_weights_, fields_.data(), out);
  }

  double w0(double t_new) override {
    check_step(kernel_, accepted_.now(), t_new);
    const Moments m = current(t_new);
    return order_ == 0 ? m.zero : m.zero - m.one;
  }

  void commit(double t_new, std::span<const double> u_new) override {
    check_field(kernel_, n_, u_new.size());
    check_step(kernel_, accepted_.now(), t_new);
    while (leaving() > 0) absorb();
    steps_.push_back(accepted_.accept(t_new));
    times_.push_back(t_new);
    fields_.push(u_new);
  }

  const HorizonEnd* ended() const override { return ended_ ? &*ended_ : nullptr; }

  HistoryReport report() const override {
    HistoryReport r;
    r.route = "fit";
    r.why = why_;
    r.fields = static_cast<std::int64_t>(sum_.state_fields() + fields_.size());
    r.bytes = 8.0 * static_cast<double>(states_.size()) + fields_.bytes();
    r.error = error_;
    r.reads = reads_;
    return r;
  }

  void save(std::ostream& out) const override {
    StateWriter w(out);
    w.put(fit_magic);
    w.put(static_cast<std::uint64_t>(n_));
    w.put(order_);
    accepted_.save(w);
    std::vector<SavedTerm> terms;
    for (const ExponentialTerm& term : terms_) terms.push_back({term.factor, term.lag_rate});
    w.put(terms);
    w.put(window_);
    w.put(horizon_);
    w.put(error_);
    w.put(times_);
    w.put(steps_);
    w.put(states_);
    w.put(fields_.packed());
  }

  /// The states belong to the exponentials they were made with: those come with them, and are
  /// verified again when the run goes beyond the time they were fitted for.
  void restore(std::istream& in) override {
    StateReader r(in, kernel_.spec.origin);
    r.expect(fit_magic, "route");
    r.expect(static_cast<std::uint64_t>(n_), "number of unknowns");
    r.expect(order_, "order");
    accepted_.restore(r);
    terms_.clear();
    for (const SavedTerm& saved : r.get_vector<SavedTerm>()) {
      if (!std::isfinite(std::abs(saved.factor)) || !std::isfinite(std::abs(saved.rate)))
        r.fail("is inconsistent");
      terms_.push_back({.factor = saved.factor, .lag_rate = saved.rate});
    }
    sum_ = ExponentialSum(terms_, false);
    window_ = r.get_finite();
    horizon_ = r.get_finite();
    error_ = r.get_finite();
    times_ = r.get_times(accepted_.start_time(), accepted_.now());
    steps_ = r.get_numbers();
    states_ = r.get_numbers();
    fields_.unpack(r.get_numbers());
    weights_.reset();
    groups_.clear();
    const std::size_t nodes = times_.size() - (order_ == 0 ? 1 : 0);
    if (times_.empty() || steps_.size() + 1 != times_.size() ||
        states_.size() != sum_.state_fields() * n_ || (n_ > 0 && fields_.size() != nodes)) {
      r.fail("is inconsistent");
    }
    if (planned_end_) check_horizon(*planned_end_); // sooner than at the first step beyond
  }

private:
  Moments current(double t_new) { return near_(kernel_, t_new, 0, accepted_.step_to(t_new)); }

  /// Number of raw intervals, from the oldest, that lie beyond the window now.
  std::size_t leaving() const {
    const double slack = 1e-9 * window_;
    std::size_t count = 0;
    while (count + 1 < times_.size() && accepted_.now() - times_[count + 1] >= window_ - slack)
      ++count;
    return count;
  }

  /// t_new minus the end of raw interval `taken` (0: of the states), as a sum of named steps: the
  /// same bits in every step of a uniform grid.
  double ahead_of(double t_new, std::size_t taken) const {
    double sum = accepted_.step_to(t_new);
    for (std::size_t j = taken; j < steps_.size(); ++j) sum += steps_[j];
    return sum;
  }

  /// Coefficients for putting in the oldest raw interval (k: its step; 0: none).
  void prepare(double k, double ahead) {
    if (!groups_.empty() && prepared_step_ == k && prepared_ahead_ == ahead) return;
    groups_ = sum_.coefficients({0.0, k}, ahead, 0.0, order_);
    prepared_step_ = k;
    prepared_ahead_ = ahead;
  }

  /// Moves the oldest raw interval into the states and reads them `ahead` of its end.
  void advance(double ahead, std::span<double> out) {
    prepare(steps_.front(), ahead);
    const std::span<const double> before = order_ == 1 ? fields_[0] : std::span<const double>();
    advance_and_read(groups_, states_, fields_[order_ == 1 ? 1 : 0], before, out);
    times_.erase(times_.begin());
    steps_.erase(steps_.begin());
    fields_.drop(1);
  }

  void absorb() {
    std::vector<double> unread(n_, 0.0);
    advance(steps_.front(), unread);
  }

  /// Lags beyond the fitted range: verified once per doubling, or the memory ends.
  void check_horizon(double t_new) {
    ended_.reset();
    const double needed = t_new - accepted_.start_time();
    if (needed <= horizon_ * (1 + 1e-9)) return;
    for (const double extended : {2 * needed, needed}) {
      const double error = fit_error(kernel_, terms_, window_, extended);
      if (!(error <= tolerance_)) continue;
      error_ = std::max(error_, error);
      horizon_ = extended;
      return;
    }
    ended_ =
        HorizonEnd{kernel_.spec.origin,
                   fmt::format("the memory `{}` was fitted for lags up to {:.6g} and is not within "
                               "its tolerance at lag {:.6g}",
                               kernel_.spec.name, horizon_, needed),
                   "run from the start with the longer end time, or with the route `tree`"};
  }

  PreparedKernel kernel_;
  ExponentialTerms terms_;
  ExponentialSum sum_;
  std::size_t n_;
  int order_;
  double window_, tolerance_, error_, horizon_;
  std::optional<double> planned_end_;
  std::optional<HorizonEnd> ended_;
  std::string why_;
  AcceptedSteps accepted_;
  WeightCache near_;
  PastWeights weights_;

  std::vector<double> states_; ///< integrals over (t0, times_.front()]
  std::vector<double> times_;  ///< ends of the raw intervals
  std::vector<double> steps_;  ///< their named lengths
  FieldQueue fields_;          ///< u at times_[1..] (order 0) or times_[0..] (order 1)
  std::vector<LinearGroup> groups_;
  std::vector<double> node_weights_;
  std::int64_t reads_ = 0;
  double prepared_step_ = -1, prepared_ahead_ = -1;
};

} // namespace

RouteOutcome make_fit(const PreparedKernel& kernel, std::size_t n, const HistoryOptions& options) {
  if (!kernel.traits.convolution) return {nullptr, "the kernel is not a convolution"};
  if (!(options.horizon > 0) || !(options.shortest_step > 0)) {
    return {nullptr, "the end time or the shortest step is not known"};
  }
  // First over all lags; a kernel with kinks also beyond the last of them.
  std::vector<double> windows{options.shortest_step};
  if (const auto& breaks = kernel.traits.breaks; !breaks.empty()) {
    if (breaks.back() > options.shortest_step && breaks.back() < 0.5 * options.horizon) {
      windows.push_back(breaks.back());
    }
  }
  std::string failure;
  for (const double window : windows) {
    if (window >= options.horizon) return {nullptr, "the whole time is one step"};
    const double decades = std::log10(options.horizon / window);
    if (decades > most_decades) {
      failure = fmt::format("its lags reach over {:.0f} decades, a fit over {:.0f} at most",
                            decades, most_decades);
      continue;
    }
    auto outcome = fit_exponentials(kernel, window, options.horizon, options.tolerance);
    if (!outcome.sum) {
      failure = outcome.failure;
      continue;
    }
    std::string why =
        fmt::format("{} exponential fields reproduce the kernel ({}) on lags {:.3g} to {:.3g}, "
                    "error {:.1e} of its norm",
                    outcome.sum->fields, kernel.traits.description, window, options.horizon,
                    outcome.sum->error);
    return {std::make_unique<FitHistory>(kernel, *outcome.sum, n, options, window, std::move(why)),
            {}};
  }
  return {nullptr, failure};
}

} // namespace hvi::solver
