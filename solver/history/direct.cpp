// The direct route: all fields are stored and summed with exact weights. O(N) per step; the
// yardstick of the other routes, and the only one that needs nothing of the kernel.
#include "solver/history/fields.hpp"
#include "solver/history/routes.hpp"
#include "solver/history/steps.hpp"
#include "solver/history/stream.hpp"

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <limits>

namespace hvi::solver {

namespace {

constexpr std::uint32_t magic = 0x44495231;

/// Weights of many intervals at one time: 15-point panels evaluated together, each checked by its
/// embedded 7-point rule, the failing ones done adaptively.
class PanelWeights {
public:
  void compute(const PreparedKernel& kernel, double t, std::span<const double> times,
               std::vector<Moments>& out) {
    const std::size_t count = times.size() - 1;
    lags_.resize(points * count);
    values_.resize(points * count);
    for (std::size_t j = 0; j < count; ++j) place(t, times[j], times[j + 1], &lags_[points * j]);
    kernel.function.evaluate(t, lags_, values_);
    out.resize(count);
    for (std::size_t j = 0; j < count; ++j) {
      const double low = t - times[j + 1], high = t - times[j];
      if (!panel(&values_[points * j], high - low, out[j])) {
        out[j] = kernel.integral(t, low, high);
      }
    }
  }

private:
  using Rule = boost::math::quadrature::gauss_kronrod<double, 15>;
  using Gauss = boost::math::quadrature::gauss<double, 7>;
  static constexpr std::size_t points = 15;

  static void place(double t, double s_low, double s_high, double* lags) {
    const double middle = t - 0.5 * (s_low + s_high), half = 0.5 * (s_high - s_low);
    lags[0] = middle;
    for (std::size_t i = 1; i < 8; ++i) {
      lags[2 * i - 1] = middle - half * Rule::abscissa()[i];
      lags[2 * i] = middle + half * Rule::abscissa()[i];
    }
  }

  static bool panel(const double* q, double length, Moments& out) {
    double k0 = 0, k1 = 0, g0 = 0, g1 = 0, magnitude = 0;
    for (std::size_t p = 0; p < points; ++p) {
      const std::size_t i = (p + 1) / 2;
      const double sign = p == 0 ? 0 : (p % 2 == 1 ? -1 : 1);
      const double x = 0.5 * (1 + sign * Rule::abscissa()[i]);
      const double w = 0.5 * Rule::weights()[i];
      k0 += w * q[p];
      k1 += w * q[p] * x;
      magnitude += w * std::abs(q[p]);
      if (i % 2 == 0) {
        g0 += 0.5 * Gauss::weights()[i / 2] * q[p];
        g1 += 0.5 * Gauss::weights()[i / 2] * q[p] * x;
      }
    }
    out = {length * k0, length * k1};
    const double bound = 2e-12 * magnitude;
    return std::abs(k0 - g0) <= bound && std::abs(k1 - g1) <= bound;
  }

  std::vector<double> lags_, values_;
};

class DirectHistory final : public History {
public:
  DirectHistory(const PreparedKernel& kernel, std::size_t n, const HistoryOptions& options,
                std::string why)
      : kernel_(kernel), n_(n), order_(options.order), why_(std::move(why)),
        steps_(options.shortest_step), fields_(n) {}

  void start(double t0, std::span<const double> u0) override {
    times_.assign(1, t0);
    fields_.clear();
    uniform_ = kernel_.traits.convolution;
    step_ = 0;
    committed_ = 0;
    by_index_.clear();
    if (order_ == 1) {
      check_field(kernel_, n_, u0.size());
      fields_.push(u0);
    }
  }

  void rhs(double t_new, std::span<double> out) override {
    check_field(kernel_, n_, out.size());
    check_step(kernel_, times_.back(), t_new);
    std::fill(out.begin(), out.end(), 0.0);
    past_weights(t_new);
    node_weights_.assign(fields_.size(), 0.0);
    for (std::size_t j = 0; j < past_.size(); ++j) {
      if (order_ == 0) {
        node_weights_[j] = past_[j].zero;
      } else {
        node_weights_[j] += past_[j].one;
        node_weights_[j + 1] += past_[j].zero - past_[j].one;
      }
    }
    if (order_ == 1) node_weights_.back() += current(t_new).one;
    add_combination(node_weights_, fields_.data(), out);
  }

  double w0(double t_new) override {
    check_step(kernel_, times_.back(), t_new);
    const Moments m = current(t_new);
    return order_ == 0 ? m.zero : m.zero - m.one;
  }

  void commit(double t_new, std::span<const double> u_new) override {
    check_field(kernel_, n_, u_new.size());
    check_step(kernel_, times_.back(), t_new);
    const double k = steps_.find(times_.back(), t_new);
    steps_.remember(k);
    if (committed_ == 0) step_ = k;
    ++committed_;
    times_.push_back(t_new);
    fields_.push(u_new);
    uniform_ = uniform_ && k == step_ && follows_grid(t_new);
    forget(t_new);
  }

  HistoryReport report() const override {
    HistoryReport r;
    r.route = "direct";
    r.why = why_;
    r.fields = static_cast<std::int64_t>(fields_.size());
    r.bytes = fields_.bytes();
    r.error = 1e-14;
    return r;
  }

  void save(std::ostream& out) const override {
    StateWriter w(out);
    w.put(magic);
    w.put(static_cast<std::uint64_t>(n_));
    w.put(order_);
    w.put(uniform_);
    w.put(step_);
    w.put(start_);
    w.put(committed_);
    w.put(steps_.known());
    w.put(times_);
    w.put(fields_.packed());
  }

  void restore(std::istream& in) override {
    StateReader r(in, kernel_.spec.origin);
    r.expect(magic, "route");
    r.expect(static_cast<std::uint64_t>(n_), "number of unknowns");
    r.expect(order_, "order");
    by_index_.clear();
    uniform_ = r.get<bool>();
    step_ = r.get<double>();
    start_ = r.get<double>();
    committed_ = r.get<std::int64_t>();
    steps_.set_known(r.get_vector<double>());
    times_ = r.get_vector<double>();
    fields_.unpack(r.get_vector<double>());
    if (times_.empty() || (n_ > 0 && fields_.size() + (order_ == 0 ? 1 : 0) != times_.size())) {
      r.fail("is inconsistent");
    }
  }

private:
  Moments current(double t_new) {
    return near_(kernel_, t_new, 0, steps_.find(times_.back(), t_new));
  }

  bool follows_grid(double t_new) {
    if (committed_ == 1) start_ = times_.front();
    const double expected = start_ + static_cast<double>(committed_) * step_;
    const double ulp =
        std::numeric_limits<double>::epsilon() * std::max(std::abs(start_), std::abs(t_new));
    return std::abs(t_new - expected) <= 16 * ulp;
  }

  /// past_[j]: weights of (times_[j], times_[j+1]).
  void past_weights(double t_new) {
    const std::size_t count = times_.size() - 1;
    past_.resize(count);
    if (count == 0) return;
    if (uniform_ && steps_.find(times_.back(), t_new) == step_) {
      while (by_index_.size() <= count) {
        const double m = static_cast<double>(by_index_.size());
        by_index_.push_back(kernel_.integral(t_new, m * step_, (m + 1) * step_));
      }
      for (std::size_t j = 0; j < count; ++j) past_[j] = by_index_[count - j];
    } else {
      panels_.compute(kernel_, t_new, times_, past_);
    }
  }

  /// Drops what no later time can see.
  void forget(double t_now) {
    const double reach = kernel_.traits.max_lag;
    if (reach <= 0) return;
    std::size_t gone = 0;
    while (gone + 1 < times_.size() && t_now - times_[gone + 1] >= reach) ++gone;
    times_.erase(times_.begin(), times_.begin() + static_cast<std::ptrdiff_t>(gone));
    fields_.drop(gone);
  }

  PreparedKernel kernel_;
  std::size_t n_;
  int order_;
  std::string why_;
  StepNames steps_;
  WeightCache near_;
  PanelWeights panels_;

  std::vector<double> times_; ///< ends of the intervals kept
  FieldQueue fields_;         ///< u at times_[1..] (order 0) or times_[0..] (order 1)
  bool uniform_ = false;      ///< all steps so far are step_: weights by lag index
  double step_ = 0, start_ = 0;
  std::int64_t committed_ = 0;
  std::vector<Moments> by_index_, past_;
  std::vector<double> node_weights_;
};

} // namespace

void check_step(const PreparedKernel& kernel, double t_before, double t_new) {
  if (!(t_new > t_before) || !std::isfinite(t_new)) {
    throw Failure(FailureKind::bad_value, kernel.spec.origin,
                  "the times of a memory must increase: " + std::to_string(t_before) +
                      " is followed by " + std::to_string(t_new));
  }
}

void check_field(const PreparedKernel& kernel, std::size_t expected, std::size_t given) {
  if (expected != given) {
    throw Failure(FailureKind::bad_value, kernel.spec.origin,
                  "a memory of " + std::to_string(expected) + " unknowns was given " +
                      std::to_string(given));
  }
}

std::unique_ptr<History> make_direct(const PreparedKernel& kernel, std::size_t n,
                                     const HistoryOptions& options, std::string why) {
  return std::make_unique<DirectHistory>(kernel, n, options, std::move(why));
}

} // namespace hvi::solver
