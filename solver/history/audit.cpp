// The audit of a memory: a few unknowns are summed directly beside the route that was chosen, with
// weights by another quadrature, and the largest difference is reported.
#include "solver/common/stream.hpp"
#include "solver/history/independent.hpp"
#include "solver/history/routes.hpp"
#include "solver/history/traits.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr std::uint32_t audit_magic = 0x41554433;

/// max |u_i|, as eight independent maxima, so that none waits for another.
double largest(std::span<const double> u) {
  std::array<double, 8> most{};
  std::size_t i = 0;
  for (; i + most.size() <= u.size(); i += most.size())
    for (std::size_t k = 0; k < most.size(); ++k) {
      const double size = std::abs(u[i + k]);
      most[k] = most[k] < size ? size : most[k];
    }
  for (; i < u.size(); ++i) most[0] = std::max(most[0], std::abs(u[i]));
  return *std::max_element(most.begin(), most.end());
}

class AuditedHistory final : public History {
public:
  AuditedHistory(const PreparedKernel& kernel, const HistoryOptions& options,
                 std::unique_ptr<History> inner, std::size_t n, std::size_t replayed)
      : kernel_(kernel), horizon_(options.horizon), expected_steps_(options.steps),
        inner_(std::move(inner)), direct_(kernel, replayed, options.order, options.shortest_step),
        sample_(replayed), replayed_(replayed), order_(options.order) {
    // A run that is continued beyond its planned end has a list of times.
    if (options.horizon > 0 && !options.times.empty()) {
      horizon_ = std::max(horizon_, options.times.back() - options.times.front());
      expected_steps_ = static_cast<std::int64_t>(options.times.size()) - 1;
    }
    for (std::size_t j = 0; j < replayed; ++j) chosen_.push_back((2 * j + 1) * n / (2 * replayed));
  }

  void start(double t0, std::span<const double> u0) override {
    inner_->start(t0, u0);
    direct_.start(t0, u0.empty() ? u0 : gather(u0));
    record_ = {};
    record_.t0 = now_ = t0;
    replays_ = true;
  }

  /// A step that is rejected later is as good an audit as any other.
  void rhs(double t_new, std::span<double> out) override {
    inner_->rhs(t_new, out);
    const std::int64_t step = record_.steps + 1;
    if (!replays_ || (step < record_.next && step != expected_steps_)) return;
    direct_.sum(t_new, replayed_);
    gather(out);
    double difference = 0;
    for (std::size_t j = 0; j < chosen_.size(); ++j) {
      difference = std::max(difference, std::abs(sample_[j] - replayed_[j]));
    }
    const double scale = norm(t_new) * record_.largest;
    if (scale > 0) record_.worst = std::max(record_.worst, difference / scale);
    if (step != record_.last) ++record_.audits; // a repeated step is one audit
    record_.last = step;
  }

  /// The weight of the current interval is no part of the sum: it has an audit of its own.
  double w0(double t_new) override {
    const double weight = inner_->w0(t_new);
    if (!replays_ || record_.last != record_.steps + 1) return weight;
    const double k = t_new - now_;
    if (kernel_.traits.convolution && std::abs(k - record_.weighed) <= 1e-12 * k) return weight;
    record_.weighed = k;
    const Moments m = independent_integral(kernel_, t_new, k);
    const double expected = order_ == 0 ? m.zero : m.zero - m.one;
    const double off = std::abs(weight - expected), scale = norm(t_new);
    if (scale > 0) record_.worst = std::max(std::isfinite(off) ? off / scale : 1.0, record_.worst);
    return weight;
  }

  void commit(double t_new, std::span<const double> u_new) override {
    inner_->commit(t_new, u_new);
    now_ = t_new;
    ++record_.steps;
    record_.field_largest = std::max(record_.field_largest, largest(u_new));
    if (!replays_) return;
    if (record_.steps >= most_audited_steps) return stop();
    direct_.commit(t_new, gather(u_new));
    for (const double u : sample_) record_.largest = std::max(record_.largest, std::abs(u));
    // Every one of the first steps, then a geometric sequence: N steps cost about as much as six
    // full sums.
    constexpr std::int64_t dense = 16;
    if (record_.steps >= record_.next)
      record_.next = record_.steps + (record_.steps < dense ? 1 : record_.steps / 5);
  }

  double audited() const override { return record_.worst; }
  const HorizonEnd* ended() const override { return inner_->ended(); }

  HistoryReport report() const override {
    HistoryReport r = inner_->report();
    r.audits = record_.audits;
    r.audited_until = record_.last;
    r.audit = record_.worst;
    r.norm = record_.norm;
    r.bound = r.error * record_.norm * record_.field_largest;
    r.bytes += direct_.bytes();
    return r;
  }

  void save(std::ostream& out) const override {
    StateWriter w(out);
    w.put(audit_magic);
    w.put(record_);
    w.put(static_cast<std::uint8_t>(replays_));
    w.put(now_);
    inner_->save(out);
    if (replays_) direct_.save(w);
  }

  void restore(std::istream& in) override {
    StateReader r(in, kernel_.spec.origin);
    r.expect(audit_magic, "audit");
    const Record saved = r.get<Record>();
    replays_ = r.get<std::uint8_t>() != 0;
    now_ = r.get_finite();
    check(saved, r);
    record_ = saved;
    if (record_.norm_until > 0) norm(record_.t0 + record_.norm_until);
    inner_->restore(in);
    if (replays_)
      direct_.restore(r);
    else
      stop();
  }

private:
  struct Record {
    double t0 = 0, largest = 0, field_largest = 0, worst = 0, norm = 0, norm_until = 0,
           weighed = -1; ///< the step whose weight was audited last
    std::int64_t steps = 0, next = 2, audits = 0, last = 0; ///< the first step has no past
  };

  void check(const Record& saved, const StateReader& r) const {
    const double elapsed = now_ - saved.t0;
    bool good = saved.steps >= 0 && saved.audits >= 0 && saved.last >= 0 && saved.next >= 0 &&
                saved.t0 == record_.t0 && elapsed >= 0.0 && saved.norm_until >= 0.0 &&
                saved.norm_until <= 2 * std::max(elapsed, horizon_);
    for (const double v : {saved.largest, saved.field_largest, saved.worst, saved.norm})
      good = good && std::isfinite(v);
    if (!good) r.fail("is inconsistent");
  }

  std::span<const double> gather(std::span<const double> field) {
    for (std::size_t j = 0; j < chosen_.size(); ++j) sample_[j] = field[chosen_[j]];
    return sample_;
  }

  /// Forgets what was stored.
  void stop() {
    replays_ = false;
    direct_.start(record_.t0, std::vector<double>(sample_.size(), 0.0));
  }

  /// The norm that the route's own error refers to; without an end time, int |q| over the lags seen
  /// so far, renewed when they have doubled.
  double norm(double t) {
    if (horizon_ > 0) {
      if (record_.norm_until < horizon_) {
        record_.norm = kernel_.norm(record_.t0, horizon_);
        record_.norm_until = horizon_;
      }
      return record_.norm;
    }
    const double elapsed = t - record_.t0;
    if (elapsed > 2 * record_.norm_until) {
      record_.norm =
          absolute_integral(kernel_.spec.expression, kernel_.traits.singular_exponent, t, elapsed);
      record_.norm_until = elapsed;
    }
    return record_.norm;
  }

  PreparedKernel kernel_;
  double horizon_;
  std::int64_t expected_steps_;
  std::unique_ptr<History> inner_;
  IndependentSum direct_;
  std::vector<std::size_t> chosen_;
  std::vector<double> sample_, replayed_;
  Record record_;
  bool replays_ = true; ///< false: the storage for it is used up
  int order_;
  double now_ = 0; ///< the last accepted time
};

} // namespace

std::unique_ptr<History> make_audited_history(const KernelSpec& kernel, std::size_t n,
                                              const HistoryOptions& options, std::size_t replayed) {
  const PreparedKernel prepared = prepare_kernel(kernel, options);
  auto inner = make_history(prepared, n, options);
  replayed = std::min(replayed, n);
  if (replayed == 0 || inner->report().route == "direct") return inner;
  return std::make_unique<AuditedHistory>(prepared, options, std::move(inner), n, replayed);
}

} // namespace hvi::solver
