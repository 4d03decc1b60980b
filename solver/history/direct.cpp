// The direct route: all fields are stored and summed with exact weights. O(N) per step; the other
// routes are compared with it, and it is the only one without conditions on the kernel.
#include "solver/common/stream.hpp"
#include "solver/history/fields.hpp"
#include "solver/history/past_weights.hpp"
#include "solver/history/routes.hpp"

#include <algorithm>

namespace hvi::solver {

namespace {

constexpr std::uint32_t direct_magic = 0x44495231;
/// Room is made at once for so many fields: the number of steps may come from an edited file.
constexpr std::int64_t most_reserved = 1 << 20;

class DirectHistory final : public History {
public:
  DirectHistory(const PreparedKernel& kernel, std::size_t n, const HistoryOptions& options,
                std::string why)
      : kernel_(kernel), n_(n), order_(options.order), why_(std::move(why)),
        expected_(options.steps), accepted_(options.shortest_step), fields_(n) {}

  void start(double t0, std::span<const double> u0) override {
    accepted_.start(t0);
    times_.assign(1, t0);
    fields_.clear();
    weights_.reset();
    if (kernel_.traits.max_lag <= 0.0)
      fields_.reserve(static_cast<std::size_t>(std::min(expected_, most_reserved) + order_));
    if (order_ == 1) {
      check_field(kernel_, n_, u0.size());
      fields_.push(u0);
    }
  }

  void rhs(double t_new, std::span<double> out) override {
    check_field(kernel_, n_, out.size());
    check_step(kernel_, accepted_.now(), t_new);
    std::fill(out.begin(), out.end(), 0.0);
    put_node_weights(weights_(kernel_, accepted_.common_step(t_new), t_new, times_), order_,
                     node_weights_);
    if (order_ == 1) node_weights_.back() += current(t_new).one;
    reads_ += static_cast<std::int64_t>(node_weights_.size());
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
    accepted_.accept(t_new);
    times_.push_back(t_new);
    fields_.push(u_new);
    forget(t_new);
  }

  HistoryReport report() const override {
    HistoryReport r;
    r.route = "direct";
    r.why = why_;
    r.fields = static_cast<std::int64_t>(fields_.size());
    r.bytes = fields_.bytes();
    r.error = 1e-14;
    r.reads = reads_;
    return r;
  }

  void save(std::ostream& out) const override {
    StateWriter w(out);
    w.put(direct_magic);
    w.put(static_cast<std::uint64_t>(n_));
    w.put(order_);
    accepted_.save(w);
    w.put(times_);
    w.put(fields_.packed());
  }

  void restore(std::istream& in) override {
    StateReader r(in, kernel_.spec.origin);
    r.expect(direct_magic, "route");
    r.expect(static_cast<std::uint64_t>(n_), "number of unknowns");
    r.expect(order_, "order");
    accepted_.restore(r);
    weights_.reset();
    times_ = r.get_times(accepted_.start_time(), accepted_.now());
    fields_.unpack(r.get_numbers());
    if (times_.empty() || (n_ > 0 && fields_.size() + (order_ == 0 ? 1 : 0) != times_.size())) {
      r.fail("is inconsistent");
    }
  }

private:
  Moments current(double t_new) { return near_(kernel_, t_new, 0, accepted_.step_to(t_new)); }

  /// Drops the fields that no later time reads.
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
  std::int64_t expected_; ///< steps
  AcceptedSteps accepted_;
  WeightCache near_;
  PastWeights weights_;
  std::vector<double> times_; ///< ends of the intervals kept
  FieldQueue fields_;         ///< u at times_[1..] (order 0) or times_[0..] (order 1)
  std::vector<double> node_weights_;
  std::int64_t reads_ = 0;
};

} // namespace

std::unique_ptr<History> make_direct(const PreparedKernel& kernel, std::size_t n,
                                     const HistoryOptions& options, std::string why) {
  return std::make_unique<DirectHistory>(kernel, n, options, std::move(why));
}

} // namespace hvi::solver
