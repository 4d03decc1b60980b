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

class Newmark : public InMotion {
public:
  Newmark(const TimeSpec& spec, double beta, double gamma)
      : InMotion(spec), beta_(beta), gamma_(gamma) {}

  double factor(int n, int derivative) const override {
    const double k = length(n);
    return derivative == 1 ? gamma_ / (beta_ * k) : 1.0 / (beta_ * k * k);
  }
  KnownTerms known(int n, int derivative) const override {
    const double k = length(n);
    if (derivative == 1)
      return {KnownTerm{1.0 - gamma_ / beta_, &velocity_},
              KnownTerm{k * (1.0 - 0.5 * gamma_ / beta_), &acceleration_}};
    return {KnownTerm{-1.0 / (beta_ * k), &velocity_},
            KnownTerm{1.0 - 0.5 / beta_, &acceleration_}};
  }
  bool needs_acceleration() const override { return true; }
  void accept(int n, Vector& d) override {
    Vector now = made_by(n, 2, d), velocity = made_by(n, 1, d);
    acceleration_.swap(now);
    velocity_.swap(velocity);
    InMotion::accept(n, d);
  }

private:
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
  double alpha_;
};

class Midpoint final : public InMotion {
public:
  using InMotion::InMotion;
  double factor(int n, int derivative) const override {
    const double k = length(n);
    return derivative == 1 ? 1.0 / k : 2.0 / (k * k);
  }
  KnownTerms known(int n, int derivative) const override {
    if (derivative == 1) return {};
    return {KnownTerm{-2.0 / length(n), &velocity_}};
  }
  void derivative(int n, int derivative, Vector& out) const override {
    InMotion::derivative(n, derivative, out);
    if (derivative == 1) out = last() / length(n);
  }
  double present(int derivative) const override { return derivative == 0 ? 0.5 : 1.0; }
  double past(int derivative) const override { return derivative == 0 ? 0.5 : 0.0; }
  void accept(int n, Vector& d) override {
    acceleration_ = made_by(n, 2, d); // that of the whole step
    velocity_ += length(n) * acceleration_;
    InMotion::accept(n, d);
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
