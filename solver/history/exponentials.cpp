// Scalar coefficients of the recursion. All exponentials are decaying ones, all moments positive
// sums: nothing cancels, neither for small nor for stiff steps.
#include "solver/history/exponentials.hpp"

#include "solver/history/proved_quadrature.hpp"

#include <boost/math/quadrature/gauss.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

/// e^z - 1 with a small z kept exact.
Complex expm1(Complex z) {
  const double s = std::sin(0.5 * z.imag()), e = std::expm1(z.real());
  return {e * std::cos(z.imag()) - 2 * s * s, (e + 1) * std::sin(z.imag())};
}

double binomial(int n, int k) {
  double b = 1;
  for (int i = 0; i < k; ++i) b = b * (n - i) / (i + 1);
  return b;
}

/// Half of a step, as seen from the end it touches: lags up to the middle from lag 0, then the
/// distance from the step's beginning, so that a layer or a singularity at either end is resolved.
struct Half {
  double t_end, k;
  bool late; ///< the half that touches lag 0
  double lag(double x) const { return late ? x : k - x; }
  /// The step's beginning; exactly 0 where it is 0 within rounding.
  double begin() const {
    const double begin = t_end - k;
    return std::abs(begin) <= 4e-16 * std::abs(t_end) ? 0.0 : begin;
  }
  double source(double x) const { return late ? t_end - x : begin() + x; }
  Strip sources(const Strip& x) const {
    return late ? difference(t_end, x) : difference(begin(), scaled(-1.0, x));
  }
  Strip lags(const Strip& x) const { return late ? x : difference(k, x); }
};

/// A bound of |lag^r e^{p lag}|.
double exponential_modulus(const Strip& lags, int r, Complex p) {
  const double most = p.real() * (p.real() > 0 ? lags.high : lags.low);
  return std::pow(std::max(std::abs(lags.low), std::abs(lags.high)) + lags.imaginary, r) *
         std::exp(most + std::abs(p.imag()) * lags.imaginary);
}

} // namespace

Complex exponential_moment(int r, Complex z) {
  if (r == 0) return std::abs(z) < 1e-200 ? Complex(1) : expm1(z) / z;
  constexpr double large = 20;
  if (std::abs(z) > large) { // upward recurrence: stable for |z| > r
    Complex moment = expm1(z) / z;
    for (int m = 1; m <= r; ++m) moment = (std::exp(z) - static_cast<double>(m) * moment) / z;
    return moment;
  }
  // 30 Gauss points are exact to rounding for entire integrands of this size.
  using Rule = boost::math::quadrature::gauss<double, 30>;
  Complex sum = 0;
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
    for (const double sign : {-1.0, 1.0}) {
      const double x = 0.5 * (1 + sign * Rule::abscissa()[i]);
      sum += 0.5 * Rule::weights()[i] * std::pow(x, r) * std::exp(z * x);
    }
  }
  return sum;
}

ExponentialSum::ExponentialSum(const ExponentialTerms& terms, bool scale_growth) {
  for (const ExponentialTerm& term : terms) {
    // One of each conjugate pair; real groups take both terms of a pair in the time factor.
    if (term.lag_rate.imag() < 0) continue;
    Group& group = group_of(term);
    if (scale_growth) group.growth = std::max(0.0, term.lag_rate.real());
    const double pair = group.complex() ? 2.0 : 1.0;
    group.top_power = std::max(group.top_power, term.power);
    group.readings.push_back(
        {term.power, pair * term.factor, term.time_rate, LineFunction(term.of_time, slot::t)});
    steady_ = steady_ && term.of_time.is_constant() && term.of_source.is_constant() &&
              term.time_rate == 0.0 && group.growth == 0;
  }
}

ExponentialSum::Group& ExponentialSum::group_of(const ExponentialTerm& term) {
  for (Group& group : groups_) {
    if (std::abs(group.rate - term.lag_rate) <= 1e-14 * std::abs(term.lag_rate) &&
        group.of_source == term.of_source) {
      return group;
    }
  }
  groups_.push_back({term.lag_rate, term.of_source, {term.of_source, source_slot}, 0, {}, 0});
  return groups_.back();
}

std::size_t ExponentialSum::state_fields() const {
  std::size_t count = 0;
  for (const Group& g : groups_)
    count += static_cast<std::size_t>(g.top_power + 1) * (g.complex() ? 2 : 1);
  return count;
}

std::vector<LinearGroup> ExponentialSum::coefficients(const Step& step, double ahead, double t0,
                                                      int order) const {
  std::vector<LinearGroup> out;
  out.reserve(groups_.size());
  for (const Group& g : groups_) out.push_back(linear(g, step, ahead, t0, order));
  return out;
}

Moments ExponentialSum::current(const Step& step) const { return weights(step, 0.0); }

/// lag' = lag + ahead:  (lag + a)^r e^{p (lag + a)} = e^{p a} sum_m C(r, m) a^{r-m} lag^m e^{p
/// lag}.
Moments ExponentialSum::weights(const Step& step, double ahead) const {
  Moments sum;
  const double t = step.t_end + ahead;
  for (const Group& group : groups_) {
    const GroupMoments m = moments(group, step);
    for (const Reading& r : group.readings) {
      // One exponent for everything: a decaying and a growing factor may overflow apart.
      const Complex factor =
          r.factor * r.of_time(t) * std::exp(r.time_rate * t + group.rate * ahead);
      for (int j = 0; j <= r.power; ++j) {
        const Complex c = factor * binomial(r.power, j) * std::pow(ahead, r.power - j);
        sum.zero += (c * m.zero[static_cast<std::size_t>(j)]).real();
        sum.one += (c * m.one[static_cast<std::size_t>(j)]).real();
      }
    }
  }
  return sum;
}

ExponentialSum::GroupMoments ExponentialSum::moments(const Group& group, const Step& step) {
  GroupMoments out;
  const double k = step.k;
  if (k == 0) { // before the first step: nothing to put in
    out.zero.assign(static_cast<std::size_t>(group.top_power) + 1, 0.0);
    out.one = out.zero;
    return out;
  }
  for (int r = 0; r <= group.top_power; ++r) {
    if (group.of_source.is_constant()) {
      const double scale = group.of_source.value() * std::pow(k, r + 1);
      out.zero.push_back(scale * exponential_moment(r, group.rate * k));
      out.one.push_back(scale * exponential_moment(r + 1, group.rate * k));
      continue;
    }
    add_source_moments(group, step, r, out);
  }
  return out;
}

void ExponentialSum::add_source_moments(const Group& group, const Step& step, int r,
                                        GroupMoments& out) {
  const double k = step.k;
  Values<5> sum{}; // the modulus first
  for (const bool late : {true, false}) {
    const Half half{step.t_end, k, late};
    const auto f = [&](double x) -> Values<5> {
      const double lag = half.lag(x);
      const Complex value =
          group.source(half.source(x)) * std::pow(lag, r) * std::exp(group.rate * lag);
      const double part = lag / k;
      return {std::abs(value), value.real(), value.imag(), value.real() * part,
              value.imag() * part};
    };
    const auto modulus = [&](double low, double high) -> Modulus {
      const Strip x = around(low, high);
      Modulus m = group.source.modulus(half.sources(x));
      m.most *= exponential_modulus(half.lags(x), r, group.rate);
      if (!std::isfinite(m.most)) m.state = std::max(m.state, Strip::State::singular);
      return m;
    };
    auto v = integrate_proved<5>(f, modulus, 0, 0.5 * k, sum[0]);
    if (!v.proved) v.integral = integrate_graded<5>(f, 0, 0.5 * k);
    if (!(v.unresolved <= 1e-12 * (sum[0] + v.size[0])))
      v.integral.fill(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t m = 0; m < sum.size(); ++m) sum[m] += v.integral[m];
  }
  out.zero.emplace_back(sum[1], sum[2]);
  out.one.emplace_back(sum[3], sum[4]);
}

LinearGroup ExponentialSum::linear(const Group& group, const Step& step, double ahead, double t0,
                                   int order) {
  LinearGroup out;
  out.dimension = static_cast<std::size_t>(group.top_power + 1) * (group.complex() ? 2 : 1);
  put_transition(group, step.k, out);
  put_input(group, step, t0, order, out);
  put_readout(group, step.t_end + ahead, ahead, t0, out);
  return out;
}

void ExponentialSum::put_transition(const Group& group, double k, LinearGroup& out) {
  const std::size_t d = out.dimension, parts = group.complex() ? 2 : 1;
  out.transition.assign(d * d, 0.0);
  const Complex decay = std::exp((group.rate - group.growth) * k);
  for (int r = 0; r <= group.top_power; ++r) {
    for (int m = 0; m <= r; ++m) {
      const Complex a = decay * binomial(r, m) * std::pow(k, r - m);
      const std::size_t row = static_cast<std::size_t>(r) * parts,
                        column = static_cast<std::size_t>(m) * parts;
      out.transition[row * d + column] = a.real();
      if (parts == 1) continue;
      out.transition[row * d + column + 1] = -a.imag();
      out.transition[(row + 1) * d + column] = a.imag();
      out.transition[(row + 1) * d + column + 1] = a.real();
    }
  }
}

/// Order 1: u = u_end (1 - x) + u_before x with x = lag / k.
void ExponentialSum::put_input(const Group& group, const Step& step, double t0, int order,
                               LinearGroup& out) {
  const GroupMoments m = moments(group, step);
  const double scale = std::exp(-group.growth * (step.t_end - t0));
  const auto put = [&](Complex value, std::vector<double>& target) {
    target.push_back(value.real() * scale);
    if (group.complex()) target.push_back(value.imag() * scale);
  };
  for (std::size_t r = 0; r < m.zero.size(); ++r) {
    put(order == 0 ? m.zero[r] : m.zero[r] - m.one[r], out.input);
    put(order == 0 ? Complex(0) : m.one[r], out.input_before);
  }
}

void ExponentialSum::put_readout(const Group& group, double t_read, double ahead, double t0,
                                 LinearGroup& out) {
  const std::size_t parts = group.complex() ? 2 : 1;
  out.readout.assign(out.dimension, 0.0);
  for (const Reading& r : group.readings) {
    // The states carry e^{-growth (t - t0)}; put back together with everything else.
    const Complex exponent =
        r.time_rate * t_read + group.growth * (t_read - t0) + (group.rate - group.growth) * ahead;
    const Complex factor = r.factor * r.of_time(t_read) * std::exp(exponent);
    for (int m = 0; m <= r.power; ++m) {
      const Complex c = factor * binomial(r.power, m) * std::pow(ahead, r.power - m);
      const std::size_t at_row = static_cast<std::size_t>(m) * parts;
      out.readout[at_row] += c.real();
      if (parts == 2) out.readout[at_row + 1] -= c.imag();
    }
  }
}

} // namespace hvi::solver
