// The globally convergent method (engine.hpp): augmented Lagrangian with semismooth Newton inside.
//
// With the shift m of each component, jhat = j + m |.|^2 / 2 is convex, and the problem reads
//     S c - theta G^T W M z - (1 - theta) G^T W M z_ref + sum w G^T lambda = r,
//     lambda in d jhat(z),
// theta = 1 where S - G^T W M G is positive definite: then this is one convex problem. Otherwise
// the largest theta of a few that keeps it so; the rest of the concave part is linearised at z_ref,
// which is moved along (difference of convex functions: the energy does not rise). For a fixed
// multiplier lambda the Moreau envelope of jhat makes a convex C^1 function of c, on which Newton
// with an exact line search converges from anywhere; then lambda is updated. gamma shrinks.
#include "solver/inequality/engine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

/// gamma as parts of the body's compliance.
constexpr double smallest_gamma = 1e-6, step_of_gamma = 10.0;
/// Below this residual so many steps that do not halve it show that rounding does not let it fall.
constexpr double nearly_solved = 1e-6;
constexpr int patience = 10;

} // namespace

struct InequalityEngine::Penalised {
  InequalityEngine& w;
  double theta = 1.0, shrink = 1.0;
  Vector lambda, z_ref; ///< per row: multiplier of jhat, point of linearisation
  Vector new_lambda, gradient, direction, s_direction, z_direction, z0, sc0;
  std::vector<GraphPoint> hits;

  explicit Penalised(InequalityEngine& engine) : w(engine), hits(engine.n_points) {
    lambda = Vector::Zero(w.n_rows);
    z_ref = w.z;
    new_lambda = lambda, gradient = direction = s_direction = Vector::Zero(w.n);
    for (int p = 0; p < w.n_points; ++p) {
      const double m = shift(p);
      const Small x = w.at(w.xi, p), z = w.at(w.z, p);
      w.put(lambda, p, {x[0] + m * z[0], x[1] + m * z[1], x[2] + m * z[2]});
      hits[p].state = w.state[p];
    }
  }

  double shift(int p) const { return w.prepared[w.points[p].law].component(w.component[p]).m; }
  double gamma(int p) const { return w.points[p].gamma * shrink; }

  /// Evaluates point p at z: new multiplier of jhat; with `stiffness`, D for the Newton matrix.
  Small evaluate(int p, const Small& zp, bool stiffness) {
    const PreparedLaw& law = w.prepared[w.points[p].law];
    const double g = gamma(p), m = shift(p);
    const Small l = w.at(lambda, p);
    Small y, out;
    for (int i = 0; i < 3; ++i) y[i] = zp[i] + g * l[i];
    const double size = law.radial() ? std::hypot(y[0], y[1], y[2]) : y[0];
    hits[p] = law.resolvent(w.component[p], size, g, hits[p]);
    const GraphPoint& hit = hits[p];
    const double ratio = law.radial() && size > 0.0 ? hit.z / size : 0.0;
    const bool at_break = hit.state < 0 || hit.state % 2 == 1;
    // Inside a piece (y - hit.z) / g is the slope there: a difference would divide rounding by g.
    const double slope = hit.s + m * hit.z;
    if (!law.radial())
      out = {at_break ? (zp[0] - hit.z) / g + l[0] : slope, 0.0, 0.0};
    else
      for (int i = 0; i < 3; ++i)
        out[i] = at_break || !(size > 0.0) ? (y[i] - ratio * y[i]) / g : slope * (y[i] / size);
    if (!stiffness) return out;
    auto& matrix = w.d[p];
    matrix.fill(0.0);
    const double k = m + hit.d;
    const double along = at_break ? 1.0 / g : k / (1.0 + g * k);
    const double across = (1.0 - ratio) / g;
    for (int i = 0; i < w.points[p].rows; ++i)
      for (int j = 0; j < w.points[p].rows; ++j) {
        const double nn = !law.radial() ? 1.0 : (size > 0.0 ? y[i] * y[j] / (size * size) : 0.0);
        matrix[3 * i + j] = (along - across) * nn + (i == j ? across : 0.0);
        if (!law.radial()) matrix[3 * i + j] = along;
        if (i == j) matrix[3 * i + j] -= theta * m;
      }
    return out;
  }

  /// xi that stands in the equation: lambda - theta m z - (1 - theta) m z_ref.
  Small force_multiplier(int p, const Small& l, const Small& zp) const {
    const double m = shift(p);
    const Small ref = w.at(z_ref, p);
    Small out;
    for (int i = 0; i < 3; ++i) out[i] = l[i] - theta * m * zp[i] - (1.0 - theta) * m * ref[i];
    return out;
  }

  /// Multipliers and states of the present z and lambda to the engine.
  void hand_over() {
    for (int p = 0; p < w.n_points; ++p) {
      const double m = shift(p);
      const Small l = w.at(lambda, p), z = w.at(w.z, p);
      w.put(w.xi, p, {l[0] - m * z[0], l[1] - m * z[1], l[2] - m * z[2]});
      w.state[p] = hits[p].state;
    }
  }

  /// Fills `gradient` at the present c (S c known); the worst componentwise ratio.
  double gradient_ratio(bool stiffness) {
    for (int p = 0; p < w.n_points; ++p) {
      const Small zp = w.at(w.z, p), l = evaluate(p, zp, stiffness);
      w.put(new_lambda, p, l);
      w.put(w.trial, p, force_multiplier(p, l, zp));
    }
    const double ratio = w.residual_ratio(w.trial);
    gradient = -w.residual;
    return ratio;
  }

  /// Slope of the function along the direction at step t, scaled by `unit`; monotone in t.
  double slope_at(double t, double unit) {
    double sum = 0.0;
    for (int i = 0; i < w.n; ++i)
      sum += direction[i] / unit * (sc0[i] + t * s_direction[i] - (*w.rhs)[i]);
    for (int p = 0; p < w.n_points; ++p) {
      Small zp = w.at(z0, p);
      const Small dp = w.at(z_direction, p);
      for (int i = 0; i < 3; ++i) zp[i] += t * dp[i];
      const Small x = force_multiplier(p, evaluate(p, zp, false), zp);
      for (int i = 0; i < 3; ++i) sum += w.points[p].weight * (dp[i] / unit) * x[i];
    }
    return sum;
  }

  /// A step with the slope along it reduced to a third or less: regula falsi with bisection.
  double line_search(double unit) {
    const double s0 = slope_at(0.0, unit);
    if (!(s0 < 0.0)) return 1.0;
    double low = 0.0, high = 1.0, s_low = s0, s_high = slope_at(1.0, unit);
    if (s_high <= 0.3 * std::abs(s0)) return 1.0;
    for (int k = 0; k < 60; ++k) {
      const double falsi = low - s_low * (high - low) / (s_high - s_low);
      const double t = k % 2 == 0 ? falsi : 0.5 * (low + high);
      const double st = slope_at(t, unit);
      if (std::abs(st) <= 0.3 * std::abs(s0)) return t;
      (st < 0.0 ? low : high) = t;
      (st < 0.0 ? s_low : s_high) = st;
    }
    return low > 0.0 ? low : high;
  }

  /// No energy without symmetry: a step that makes the residual smaller.
  double damping() {
    const double before = gradient.lpNorm<Eigen::Infinity>();
    for (double t = 1.0; t > 1e-6; t /= 2.0) {
      w.c += t * direction;
      w.z = z0 + t * z_direction;
      w.update_product();
      gradient_ratio(false);
      const double after = gradient.lpNorm<Eigen::Infinity>();
      w.c -= t * direction;
      w.z = z0;
      if (after <= (1.0 - 0.1 * t) * before) return t;
    }
    return 1e-3;
  }

  Outcome minimise(int limit, double tolerance) {
    w.update_product();
    w.update_z();
    double best = std::numeric_limits<double>::infinity();
    for (int k = 0, in_vain = 0; k < limit; ++k) {
      const double ratio = gradient_ratio(true);
      if (ratio <= tolerance) return Outcome::solved;
      in_vain = ratio <= 0.5 * best ? 0 : in_vain + 1;
      best = std::min(best, ratio);
      if (best <= nearly_solved && in_vain >= patience) return Outcome::failed; // at rounding
      if (!w.factor_if_needed()) return Outcome::indefinite;
      w.op.solve(w.residual, direction);
      const double unit = direction.lpNorm<Eigen::Infinity>();
      if (!(unit > 0.0) || !std::isfinite(unit)) return Outcome::failed;
      ++w.report.iterations;
      double t = 1.0;
      z_direction = w.problem.g * direction;
      z0 = w.z, sc0 = w.sc;
      if (w.op.symmetric()) {
        w.op.apply(direction, s_direction);
        t = line_search(unit);
      } else {
        t = damping();
      }
      w.c += t * direction;
      // Not G c + g again: its rounding, which depends on the axes, would be divided by gamma.
      w.z = z0 + t * z_direction;
      w.update_product();
    }
    return Outcome::failed;
  }

  /// The largest theta of a few that leaves the smooth part positive definite.
  bool choose_theta() {
    for (const double candidate : {1.0, 0.75, 0.5, 0.25, 0.0}) {
      theta = candidate;
      for (int p = 0; p < w.n_points; ++p) {
        w.d[p].fill(0.0);
        for (int i = 0; i < w.points[p].rows; ++i) w.d[p][4 * i] = -theta * shift(p);
      }
      if (w.factor_if_needed()) return true;
    }
    return false;
  }
};

InequalityEngine::Outcome InequalityEngine::fallback() {
  report.used_fallback = true;
  update_z();
  Penalised f(*this);
  if (!f.choose_theta()) return Outcome::indefinite;
  double least = smallest_gamma;
  for (int outer = 0; outer < 80; ++outer) {
    const auto inner = f.minimise(options.max_iterations, 1e-2 * options.tolerance);
    if (inner == Outcome::indefinite) return inner;
    f.gradient_ratio(false);
    f.lambda = f.new_lambda, f.z_ref = z;
    const Vector kept_c = c;
    f.hand_over();
    for (int p = 0; p < n_points; ++p) classify(p, 1.0);
    if (newton(12) == Outcome::solved) return Outcome::solved;
    c = kept_c;
    update_z();
    f.hand_over();
    snap_factor = certificate_snap;
    // Where multipliers are not unique (more points than unknowns) Newton's states may never
    // settle.
    if (inner == Outcome::solved && try_multipliers() <= options.tolerance) {
      xi = trial;
      return Outcome::solved;
    }
    // The multipliers have the rounding of z by gamma: it may be too small to solve anything.
    if (inner == Outcome::failed && f.shrink < 1.0)
      least = f.shrink = std::min(1.0, f.shrink * step_of_gamma);
    else
      f.shrink = std::max(f.shrink / step_of_gamma, least);
  }
  return Outcome::failed;
}

} // namespace hvi::solver
