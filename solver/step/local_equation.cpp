// See local_equation.hpp. Called for every point by PointStates.
#include "solver/step/local_equation.hpp"

#include "solver/linear/dense.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

constexpr double rounding_unit = std::numeric_limits<double>::epsilon();
/// What is left of a residual whose terms cancel.
constexpr double nearly_rounding = 1e3 * rounding_unit;
constexpr int most_expansions = 200;
constexpr int most_bisections = 200;
constexpr int most_local_newton = 60;
constexpr int most_sweeps = 400;
constexpr double shortest_step = 1.0 / 1024.0;

/// r(z) = z_i - b_i - c g_i(z) of one of the equations, the others' values held.
class OneEquation {
public:
  OneEquation(const LocalEquation& all, std::span<double> z, std::size_t i)
      : all_(all), z_(z), i_(i), g_(z.size()), by_(z.size() * z.size()) {}

  double low() const { return all_.low[i_]; }
  double high() const { return all_.high[i_]; }
  double residual(double value) {
    z_[i_] = value;
    all_.rates(z_, g_);
    return value - all_.known[i_] - all_.factor * g_[i_];
  }
  /// At the last value.
  double slope() {
    all_.derivatives(z_, by_);
    return 1.0 - all_.factor * by_[i_ * z_.size() + i_];
  }
  /// Of the terms of the residual at the last value.
  double size() const {
    return std::abs(z_[i_]) + std::abs(all_.known[i_]) + std::abs(all_.factor * g_[i_]);
  }

private:
  const LocalEquation& all_;
  std::span<double> z_;
  std::size_t i_;
  std::vector<double> g_, by_;
};

/// Between `inside`, where the residual has a sign, and `outside`, where it has none (a rate that
/// is not defined there): moves both together until the sign changes or nothing is left between.
bool bracket_before_the_edge(OneEquation& e, double& inside, double& outside, double sign) {
  for (int k = 0; k < most_bisections; ++k) {
    const double middle = inside + (outside - inside) / 2.0;
    if (middle == inside || middle == outside) return false;
    const double r = e.residual(middle);
    if (!std::isfinite(r)) {
      outside = middle;
      continue;
    }
    if (r * sign <= 0.0) {
      outside = middle;
      return true;
    }
    inside = middle;
  }
  return false;
}

/// The root between a and b, where the residual has other signs.
double root_between(OneEquation& e, double a, double b, double sign_at_a) {
  double z = a;
  for (int k = 0; k < most_bisections; ++k) {
    const double r = e.residual(z);
    if (std::abs(r) <= 2.0 * rounding_unit * e.size()) return z;
    (r * sign_at_a > 0.0 ? a : b) = z;
    double next = z - r / e.slope();
    const bool between = next > std::min(a, b) && next < std::max(a, b);
    // Newton's steps must halve the bracket now and then.
    if (!between || k % 4 == 3) next = a + (b - a) / 2.0;
    if (next == a || next == b || next == z) return z;
    z = next;
  }
  return z;
}

/// The first solution from z[i] on. False: the rate is not finite, or no end is found.
bool solve_one(const LocalEquation& all, std::span<double> z, std::size_t i) {
  OneEquation e(all, z, i);
  const double start = std::clamp(z[i], e.low(), e.high());
  const double r = e.residual(start);
  if (!std::isfinite(r)) return false;
  if (std::abs(r) <= 2.0 * rounding_unit * e.size()) return true;
  const double sign = r > 0.0 ? 1.0 : -1.0, end = r > 0.0 ? e.low() : e.high();
  // Newton's step first, so that a root is not stepped over where the rate falls steeply.
  double inside = start, step = 1.5 * std::abs(r) / std::max(1.0, e.slope());
  for (int k = 0; k < most_expansions; ++k, step *= 2.0) {
    double outside = start - sign * step;
    const bool at_end = sign > 0.0 ? outside <= end : outside >= end;
    if (at_end) outside = end;
    if (inside == end) return true; // the residual would take it out: it stays
    if (!std::isfinite(outside)) return false;
    const double there = e.residual(outside);
    if (std::isfinite(there) && there * sign > 0.0) {
      inside = outside;
      continue;
    }
    if (!std::isfinite(there) && !bracket_before_the_edge(e, inside, outside, sign)) return false;
    e.residual(root_between(e, inside, outside, sign));
    return true;
  }
  return false;
}

/// The same zeros as the equations have z = P(z - s (z - b - c g)), for any s > 0. With s = 1 a
/// state that falls fast would be taken for one that is held at its lower end.
class System {
public:
  System(const LocalEquation& e, std::span<double> z)
      : e_(e), z_(z), n_(static_cast<Eigen::Index>(z.size())), g_(z.size()), scale_(z.size(), 1.0),
        by_(z.size() * z.size()) {}

  bool newton() {
    Vector r;
    rescale();
    double error = residual(r);
    if (!std::isfinite(error)) return false;
    for (int k = 0; k < most_local_newton && error > 2.0 * rounding_unit; ++k) {
      const Vector step = solve_square(jacobian(), r);
      if (!step.allFinite()) return false;
      const double after = shorten(step, error, r);
      if (!(after < error)) break;
      rescale();
      error = residual(r);
    }
    return error <= nearly_rounding || is_rounding_of_terms(r);
  }

  bool one_by_one() {
    Vector r;
    for (int sweep = 0; sweep < most_sweeps; ++sweep) {
      for (std::size_t i = 0; i < z_.size(); ++i)
        if (!solve_one(e_, z_, i)) return false;
      rescale();
      if (residual(r) <= 16.0 * rounding_unit) return true;
    }
    return residual(r) <= nearly_rounding || is_rounding_of_terms(r);
  }

private:
  /// Is the residual at z what rounding leaves of the terms that the rates are made of?
  bool is_rounding_of_terms(const Vector& r) const {
    if (!e_.terms || !r.allFinite()) return false;
    std::vector<double> terms(z_.size());
    e_.terms(z_, terms);
    for (std::size_t i = 0; i < z_.size(); ++i) {
      const double size =
          std::abs(z_[i]) + scale_[i] * (std::abs(e_.known[i]) + e_.factor * terms[i]);
      if (!(std::abs(r[static_cast<Eigen::Index>(i)]) <= nearly_rounding * size)) return false;
    }
    return true;
  }

  /// s_i = 1 / max(1, 1 - c dg_i/dz_i), and the derivatives, here.
  void rescale() {
    e_.derivatives(z_, by_);
    for (std::size_t i = 0; i < z_.size(); ++i) {
      const double steep = 1.0 - e_.factor * by_[i * z_.size() + i];
      scale_[i] = steep > 1.0 ? 1.0 / steep : 1.0;
    }
  }

  /// z_i - s_i (z_i - b_i - c g_i): kept in the box it would be z_i.
  double moved(std::size_t i) const {
    return z_[i] - scale_[i] * (z_[i] - e_.known[i] - e_.factor * g_[i]);
  }

  /// max_i |r_i| / (|z_i| + s_i (|b_i| + |c g_i|)), and the residual r_i = z_i - P_i(moved_i).
  double residual(Vector& r) {
    e_.rates(z_, g_);
    double worst = 0.0;
    r.resize(n_);
    for (std::size_t i = 0; i < z_.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (!std::isfinite(moved(i))) return std::numeric_limits<double>::infinity();
      r[k] = z_[i] - std::clamp(moved(i), e_.low[i], e_.high[i]);
      const double size =
          std::abs(z_[i]) + scale_[i] * (std::abs(e_.known[i]) + std::abs(e_.factor * g_[i]));
      if (r[k] != 0.0) worst = std::max(worst, std::abs(r[k]) / size);
    }
    return worst;
  }

  /// Goes back along the step, halved until the residual is below `error`; its size, or `error`
  /// where none is and nothing has moved.
  double shorten(const Vector& step, double error, Vector& r) {
    const std::vector<double> before(z_.begin(), z_.end());
    for (double t = 1.0; t >= shortest_step; t /= 2.0) {
      for (std::size_t i = 0; i < z_.size(); ++i)
        z_[i] =
            std::clamp(before[i] - t * step[static_cast<Eigen::Index>(i)], e_.low[i], e_.high[i]);
      if (const double after = residual(r); after < error) return after;
    }
    std::ranges::copy(before, z_.begin());
    return error;
  }

  DenseMatrix jacobian() const {
    DenseMatrix out = DenseMatrix::Identity(n_, n_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (moved(k) <= e_.low[k] || moved(k) >= e_.high[k]) continue;
      for (Eigen::Index j = 0; j < n_; ++j) {
        const double slope = by_[k * z_.size() + static_cast<std::size_t>(j)];
        const double of_rate = std::isfinite(slope) ? e_.factor * slope : 0.0;
        out(i, j) = scale_[k] * (out(i, j) - of_rate);
      }
    }
    return out;
  }

  const LocalEquation& e_;
  std::span<double> z_;
  Eigen::Index n_;
  std::vector<double> g_, scale_, by_;
};

} // namespace

bool solve_local(const LocalEquation& equation, std::span<double> z) {
  if (z.size() == 1) return solve_one(equation, z, 0);
  const std::vector<double> start(z.begin(), z.end());
  System system(equation, z);
  if (system.newton()) return true;
  std::ranges::copy(start, z.begin());
  return system.one_by_one();
}

} // namespace hvi::solver
