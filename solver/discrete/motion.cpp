// The schemes of problems with u''; see motion.hpp.
#include "solver/discrete/motion.hpp"

#include "solver/linear/vector_stream.hpp"

#include <utility>

namespace hvi::solver {
namespace {

/// Carries the velocity v_n and the acceleration a_n.
class InMotion : public TimeScheme {
public:
  using TimeScheme::TimeScheme;

  void derivative(int, int derivative, Vector& out) const override {
    out = derivative == 1 ? velocity_ : acceleration_;
  }
  void start(int n_state) override {
    TimeScheme::start(n_state);
    velocity_ = acceleration_ = Vector::Zero(n_state);
  }
  void start_motion(const Vector& velocity, const Vector& acceleration) override {
    velocity_ = velocity, acceleration_ = acceleration;
  }
  const Vector* velocity() const override { return &velocity_; }
  void save(StateWriter& w) const override {
    TimeScheme::save(w);
    put_vector(w, velocity_);
    put_vector(w, acceleration_);
  }
  void restore(StateReader& r) override {
    TimeScheme::restore(r);
    get_vector(r, velocity_, velocity_.size());
    get_vector(r, acceleration_, acceleration_.size());
  }

protected:
  double length(int n) const { return grid().length(n); }
  /// u^(j)(t_n) of the increment d, before it is accepted.
  Vector made_by(int n, int j, const Vector& d) const {
    Vector out = factor(n, j) * d;
    for (const auto& [factor, of] : known(n, j))
      if (of != nullptr) out += factor * *of;
    return out;
  }
  Vector velocity_, acceleration_;
};

/// v_n = factor_n d_n - carry_n d_{n-1}, a_n = factor_n (v_n - v_{n-1}) - carry_n (v_{n-1} -
/// v_{n-2}); carry 0: backward Euler.
class BackwardDifferences final : public InMotion {
public:
  BackwardDifferences(const TimeSpec& spec, bool second_order)
      : InMotion(spec), second_order_(second_order) {}

  double factor(int n, int derivative) const override {
    const double factor = weights(n).factor;
    return derivative == 1 ? factor : factor * factor;
  }
  KnownTerms known(int n, int derivative) const override {
    const auto [factor, carry] = weights(n);
    if (derivative == 1) return {KnownTerm{-carry, carry == 0.0 ? nullptr : &last()}};
    KnownTerms out{KnownTerm{-factor, &velocity_}};
    if (carry == 0.0) return out;
    out[1] = {-factor * carry, &last()};
    out[2] = {-carry, &gained_};
    return out;
  }
  void start(int n_state) override {
    InMotion::start(n_state);
    gained_ = Vector::Zero(n_state);
  }
  void accept(int n, Vector& d) override {
    acceleration_ = made_by(n, 2, d);
    Vector now = made_by(n, 1, d);
    gained_ = now - velocity_;
    velocity_.swap(now);
    InMotion::accept(n, d);
  }
  void save(StateWriter& w) const override {
    InMotion::save(w);
    put_vector(w, gained_);
  }
  void restore(StateReader& r) override {
    InMotion::restore(r);
    get_vector(r, gained_, gained_.size());
  }

private:
  Bdf2Weights weights(int n) const {
    return second_order_ ? bdf2_at(grid(), n) : Bdf2Weights{1.0 / length(n), 0.0};
  }
  bool second_order_;
  Vector gained_; ///< v_n - v_{n-1}
};

/// Schemes whose velocities follow from those of the step before, but for imposed entries
/// (motion.hpp): for these a step begins with others, from which its formulas make what they have.
class Recursive : public InMotion {
public:
  using InMotion::InMotion;
  void impose(int n, Eigen::Index first, const Vector& d) override {
    begun_velocity_ = velocity_, begun_acceleration_ = acceleration_;
    if (gained_.size() == 0) gained_ = Vector::Zero(d.size());
    const double k = length(n);
    const auto [factor, carry] = bdf2_at(grid(), n);
    for (Eigen::Index i = first; i < d.size(); ++i) {
      const double v = velocity_[i], a = acceleration_[i];
      const double now = n == 1 ? 2.0 / k * d[i] - v : factor * d[i] - carry * last()[i];
      const double mean = (now - v) / k, // half a step before t_n
          at_end = n == 1 ? 2.0 * mean - a : factor * (now - v) - carry * gained_[i];
      begin_with(k, d[i], now, at_end + 2.0 * shift() * (at_end - mean), begun_velocity_[i],
                 begun_acceleration_[i]);
    }
  }
  void save(StateWriter& w) const override {
    InMotion::save(w);
    w.put(static_cast<std::uint64_t>(gained_.size()));
    if (gained_.size() > 0) put_vector(w, gained_);
  }
  void restore(StateReader& r) override {
    InMotion::restore(r);
    gained_.resize(0);
    const auto size = static_cast<std::uint64_t>(velocity_.size());
    if (r.get_between<std::uint64_t>(0, size) == size) get_vector(r, gained_, velocity_.size());
  }

protected:
  /// So many steps after t_n is the time of a_n.
  virtual double shift() const { return 0.0; }
  /// The v_{n-1} and a_{n-1} of an entry that make v_n and a_n in step n, of length k and increment
  /// d; given are those that it has.
  virtual void begin_with(double k, double d, double v_n, double a_n, double& v,
                          double& a) const = 0;
  const Vector& begun_velocity() const {
    return begun_velocity_.size() > 0 ? begun_velocity_ : velocity_;
  }
  const Vector& begun_acceleration() const {
    return begun_acceleration_.size() > 0 ? begun_acceleration_ : acceleration_;
  }
  /// Step n ends with these. Leaves any vectors in their places.
  void take(int n, Vector& velocity, Vector& acceleration, Vector& d) {
    if (gained_.size() > 0) gained_ = velocity - velocity_;
    velocity_.swap(velocity);
    acceleration_.swap(acceleration);
    InMotion::accept(n, d);
  }

private:
  Vector begun_velocity_, begun_acceleration_; ///< where entries are imposed
  Vector gained_;                              ///< v_n - v_{n-1}, there
};

class Newmark : public Recursive {
public:
  Newmark(const TimeSpec& spec, double beta, double gamma)
      : Recursive(spec), beta_(beta), gamma_(gamma) {}

  double factor(int n, int derivative) const override {
    const double k = length(n);
    return derivative == 1 ? gamma_ / (beta_ * k) : 1.0 / (beta_ * k * k);
  }
  KnownTerms known(int n, int derivative) const override {
    const double k = length(n);
    if (derivative == 1)
      return {KnownTerm{1.0 - gamma_ / beta_, &begun_velocity()},
              KnownTerm{k * (1.0 - 0.5 * gamma_ / beta_), &begun_acceleration()}};
    return {KnownTerm{-1.0 / (beta_ * k), &begun_velocity()},
            KnownTerm{1.0 - 0.5 / beta_, &begun_acceleration()}};
  }
  bool needs_acceleration() const override { return true; }
  void accept(int n, Vector& d) override {
    Vector acceleration = made_by(n, 2, d), velocity = made_by(n, 1, d);
    take(n, velocity, acceleration, d);
  }

private:
  /// d = k v + k^2 ((1/2 - beta) a + beta a_n),  v_n = v + k ((1 - gamma) a + gamma a_n).
  void begin_with(double k, double d, double v_n, double a_n, double& v, double& a) const override {
    a = (d / k - v_n + k * (gamma_ - beta_) * a_n) / (k * (gamma_ - beta_ - 0.5));
    v = v_n - k * ((1.0 - gamma_) * a + gamma_ * a_n);
  }

  double beta_, gamma_;
};

class HilberHughesTaylor final : public Newmark {
public:
  explicit HilberHughesTaylor(const TimeSpec& spec)
      : Newmark(spec, 0.25 * (1.0 - spec.hht_alpha) * (1.0 - spec.hht_alpha), 0.5 - spec.hht_alpha),
        alpha_(spec.hht_alpha) {}
  double present(int derivative) const override {
    return derivative == 2 ? 1.0 / (1.0 + alpha_) : 1.0;
  }
  double past(int derivative) const override {
    return derivative == 2 ? 0.0 : -alpha_ / (1.0 + alpha_);
  }
  double past_of_laws() const override { return past(0); }

private:
  /// M a_n balances (1 + alpha) F_n - alpha F_{n-1}, the forces at t_n + alpha k.
  double shift() const override { return alpha_; }
  double alpha_;
};

class Midpoint final : public Recursive {
public:
  using Recursive::Recursive;
  double factor(int n, int derivative) const override {
    const double k = length(n);
    return derivative == 1 ? 1.0 / k : 2.0 / (k * k);
  }
  KnownTerms known(int n, int derivative) const override {
    if (derivative == 1) return {};
    return {KnownTerm{-2.0 / length(n), &begun_velocity()}};
  }
  void derivative(int n, int derivative, Vector& out) const override {
    Recursive::derivative(n, derivative, out);
    if (derivative == 1) out = last() / length(n);
  }
  double present(int derivative) const override { return derivative == 0 ? 0.5 : 1.0; }
  double past(int derivative) const override { return derivative == 0 ? 0.5 : 0.0; }
  void accept(int n, Vector& d) override {
    Vector acceleration = made_by(n, 2, d); // that of the whole step
    Vector velocity = velocity_ + length(n) * acceleration;
    take(n, velocity, acceleration, d);
  }

private:
  /// The acceleration of the step is 2 (d / k - v) / k: that from v, as it is, to v_n.
  void begin_with(double k, double d, double v_n, double /*a_n*/, double& v,
                  double& /*a*/) const override {
    v = d / k - 0.5 * (v_n - v);
  }
};

} // namespace

std::unique_ptr<TimeScheme> scheme_of_motion(const TimeSpec& spec) {
  constexpr double beta = 0.25, gamma = 0.5; // the trapezoidal rule
  switch (spec.scheme) {
  case Scheme::backward_euler:
    return std::make_unique<BackwardDifferences>(spec, false);
  case Scheme::bdf2:
    return std::make_unique<BackwardDifferences>(spec, true);
  case Scheme::newmark:
    return std::make_unique<Newmark>(spec, beta, gamma);
  case Scheme::hht:
    return std::make_unique<HilberHughesTaylor>(spec);
  case Scheme::midpoint:
    return std::make_unique<Midpoint>(spec);
  }
  return nullptr;
}

} // namespace hvi::solver
