// The symbolic route: exact recursion, a few fields whatever the number of steps. For one
// exponential it is that of a Maxwell element: M. Kaliske, H. Rothert, Formulation and
// implementation of three-dimensional viscoelasticity at small and finite strains, Comput. Mech. 19
// (1997) 228-239.
#include "solver/common/stream.hpp"
#include "solver/history/exponentials.hpp"
#include "solver/history/routes.hpp"
#include "solver/history/steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr std::uint32_t recursion_magic = 0x52454331;

class RecursionHistory final : public History {
public:
  RecursionHistory(const PreparedKernel& kernel, const ExponentialTerms& terms, std::size_t n,
                   const HistoryOptions& options, double error, std::string why)
      : kernel_(kernel), sum_(terms), n_(n), order_(options.order), error_(error),
        why_(std::move(why)), accepted_(options.shortest_step) {}

  void start(double t0, std::span<const double> u0) override {
    accepted_.start(t0);
    pending_ = false;
    states_.assign(sum_.state_fields() * n_, 0.0);
    last_.assign(n_, 0.0);
    before_.assign(order_ == 1 ? n_ : 0, 0.0);
    if (order_ == 1) {
      check_field(kernel_, n_, u0.size());
      std::copy(u0.begin(), u0.end(), last_.begin());
    }
  }

  /// Puts the last accepted interval into the states in the same pass that reads them. A repeated
  /// call finds it there: the states hold accepted values only.
  void rhs(double t_new, std::span<double> out) override {
    check_field(kernel_, n_, out.size());
    check_step(kernel_, accepted_.now(), t_new);
    const double k = accepted_.step_to(t_new);
    if (order_ == 1) {
      set_scaled(sum_.current({t_new, k}).one, last_, out);
    } else {
      std::fill(out.begin(), out.end(), 0.0);
    }
    prepare(k);
    reads_ += stored_fields();
    if (pending_) {
      advance_and_read(groups_, states_, last_, before_, out);
      pending_ = false;
    } else {
      read_states(groups_, states_, out);
    }
  }

  double w0(double t_new) override {
    check_step(kernel_, accepted_.now(), t_new);
    const double k = accepted_.step_to(t_new);
    if (sum_.steady() && k == weighed_step_) return weight_;
    const Moments m = sum_.current({t_new, k});
    if (!std::isfinite(m.zero) || !std::isfinite(m.one)) refuse(t_new, k);
    weighed_step_ = k;
    return weight_ = order_ == 0 ? m.zero : m.zero - m.one;
  }

  void commit(double t_new, std::span<const double> u_new) override {
    check_field(kernel_, n_, u_new.size());
    check_step(kernel_, accepted_.now(), t_new);
    if (pending_) absorb();
    step_ = accepted_.accept(t_new);
    if (order_ == 1) std::swap(before_, last_);
    std::copy(u_new.begin(), u_new.end(), last_.begin());
    pending_ = true;
  }

  HistoryReport report() const override {
    HistoryReport r;
    r.route = "recursion";
    r.why = why_;
    r.fields = stored_fields();
    r.bytes = 8.0 * static_cast<double>(states_.size() + last_.size() + before_.size());
    r.error = error_;
    r.reads = reads_;
    return r;
  }

  void save(std::ostream& out) const override {
    StateWriter w(out);
    w.put(recursion_magic);
    w.put(static_cast<std::uint64_t>(n_));
    w.put(order_);
    w.put(static_cast<std::uint64_t>(sum_.state_fields()));
    accepted_.save(w);
    w.put(step_);
    w.put(static_cast<std::uint8_t>(pending_));
    w.put(states_);
    w.put(last_);
    w.put(before_);
  }

  void restore(std::istream& in) override {
    StateReader r(in, kernel_.spec.origin);
    r.expect(recursion_magic, "route");
    r.expect(static_cast<std::uint64_t>(n_), "number of unknowns");
    r.expect(order_, "order");
    r.expect(static_cast<std::uint64_t>(sum_.state_fields()), "kernel");
    accepted_.restore(r);
    step_ = r.get_finite();
    pending_ = r.get<std::uint8_t>() != 0;
    states_ = r.get_numbers();
    last_ = r.get_numbers();
    before_ = r.get_numbers();
    groups_.clear();
    if (states_.size() != sum_.state_fields() * n_ || last_.size() != n_ ||
        before_.size() != (order_ == 1 ? n_ : 0)) {
      r.fail("is inconsistent");
    }
  }

private:
  std::int64_t stored_fields() const {
    return static_cast<std::int64_t>(sum_.state_fields()) + 1 + (order_ == 1 ? 1 : 0);
  }

  [[noreturn]] void refuse(double t, double k) const {
    throw Failure(FailureKind::bad_kernel, kernel_.spec.origin,
                  fmt::format("the memory kernel `{}` has no finite integral over s from {:.6g} to "
                              "{:.6g}, or changes too fast for one",
                              kernel_.spec.name, t - k, t));
  }

  /// Coefficients for putting in (t - step, t] and reading at t + ahead.
  void prepare(double ahead) {
    if (sum_.steady() && !groups_.empty() && prepared_step_ == step_ && prepared_ahead_ == ahead) {
      return;
    }
    groups_ = sum_.coefficients({accepted_.now(), step_}, ahead, accepted_.start_time(), order_);
    for (const LinearGroup& group : groups_)
      for (const double value : group.input)
        if (!std::isfinite(value)) refuse(accepted_.now(), step_);
    prepared_step_ = step_;
    prepared_ahead_ = ahead;
  }

  /// Two commits without a rhs between them: no one reads, so the pass writes into a scrap field.
  void absorb() {
    prepare(step_);
    std::vector<double> unread(n_, 0.0);
    advance_and_read(groups_, states_, last_, before_, unread);
    pending_ = false;
  }

  PreparedKernel kernel_;
  ExponentialSum sum_;
  std::size_t n_;
  int order_;
  double error_;
  std::string why_;
  AcceptedSteps accepted_;

  std::int64_t reads_ = 0;
  double step_ = 0;                   ///< the last accepted one
  bool pending_ = false;              ///< (t - step_, t] is in last_ but not yet in the states
  std::vector<double> states_;        ///< integrals over (t0, t - step_] or (t0, t]
  std::vector<double> last_, before_; ///< u(t), u(t - step_), t the time now
  std::vector<LinearGroup> groups_;
  double prepared_step_ = -1, prepared_ahead_ = -1;
  double weighed_step_ = -1, weight_ = 0; ///< w0 of the last step asked for
};

} // namespace

std::unique_ptr<History> make_recursion(const PreparedKernel& kernel, const ExponentialTerms& terms,
                                        std::size_t n, const HistoryOptions& options, double error,
                                        std::string why) {
  return std::make_unique<RecursionHistory>(kernel, terms, n, options, error, std::move(why));
}

} // namespace hvi::solver
