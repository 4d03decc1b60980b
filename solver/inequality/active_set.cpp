// Semismooth Newton on graph states (engine.hpp).
//
// Each point stands on a point (z_hat, xi_hat) of its component's graph with a stiffness D. One
// step solves  (S + sum w G^T D G) dc = r - S c - G^T W (xi_hat + D (z - z_hat)), and the resolvent
// of z + gamma (xi + m z) gives every point its next place. When the places stay, what is left is
// Newton's method for smooth slopes; with affine pieces the first step is exact.
#include "solver/inequality/engine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace hvi::solver {

namespace {

/// States and sides: a radial point of one row that slips to and fro stays in one state.
std::uint64_t hash_of(const std::vector<int>& state, const Vector& xi_hat) {
  std::uint64_t h = 1469598103934665603ULL;
  const auto mix = [&](int v) { h = (h ^ static_cast<std::uint64_t>(v + 1)) * 1099511628211ULL; };
  for (const int v : state) mix(v);
  for (const double v : xi_hat) mix(v < 0.0 ? 1 : 2);
  return h;
}

} // namespace

/// H from the stiffnesses.
void InequalityEngine::assemble() {
  double* values = h.valuePtr();
  std::fill(values, values + h.nonZeros(), 0.0);
  for (int p = 0; p < n_points; ++p)
    for (int k = first_contribution[p]; k < first_contribution[p + 1]; ++k) {
      const Contribution& q = contributions[k];
      values[q.value] += q.coefficient * d[p][q.entry];
    }
}

/// Factors S + H unless that is what is factored already.
bool InequalityEngine::factor_if_needed() {
  if (factored && d == d_factored) return true;
  assemble();
  ++report.factorisations;
  d_factored = d;
  factored = op.factor(h, held_unknowns());
  forget_far();
  return factored;
}

/// dc = (S + H)^-1 residual: by the factor, or by conjugate gradients preconditioned with the last
/// one when few points moved far from it (slopes that change a little, a front of slip).
bool InequalityEngine::solve_linear() {
  cg_r.setZero();
  const bool same = factored && d == d_factored;
  if (!same && factor_is_close() && conjugate_gradients()) return true;
  if (!factor_if_needed()) return false;
  freed.clear(), changed.clear();
  if (!same && !idle && op.rounded()) { // the next step of Newton's refines it
    prepare_drift();
    if (conjugate_gradients()) return true;
  }
  cg_r.setZero();
  op.solve(residual, dc);
  return true;
}

/// S c, unless c is what it was.
void InequalityEngine::update_product() {
  if (c == c_of_product) return;
  op.apply(c, sc);
  c_of_product = c;
  have_magnitude = false;
}

double InequalityEngine::worst_ratio() const {
  const double noise = n > 0 ? 0x1p-53 * row_size.maxCoeff() : 0.0;
  double worst = 0.0;
  for (int i = 0; i < n; ++i) {
    // A row where nothing acts (0 = 0) holds rounding of the others: no error of its own.
    const double error = std::abs(residual[i]);
    if (error <= noise || error <= worst * row_size[i]) continue;
    worst = error / row_size[i];
    if (std::isnan(worst)) return std::numeric_limits<double>::infinity();
  }
  return worst;
}

/// First against |r| + |S_ii c_i| + |(S c)_i - S_ii c_i| + |G^T W x|, which bounds the ratio from
/// above; |S||c| only where that could decide, as it gains two digits at the most: it costs another
/// pass over S.
double InequalityEngine::residual_ratio(const Vector& x) {
  gather_with_magnitude(x);
  for (int i = 0; i < n; ++i) {
    residual[i] = (*rhs)[i] - sc[i] - force[i];
    const double own = diagonal[i] * c[i];
    row_size[i] = std::abs((*rhs)[i]) + std::abs(own) + std::abs(sc[i] - own) + force_magnitude[i];
  }
  const double bound = worst_ratio();
  if (!(bound > target()) || bound > 1e2 * target()) return bound;
  if (!have_magnitude) op.apply_magnitude(c, magnitude);
  have_magnitude = true;
  row_size = rhs->cwiseAbs() + magnitude + force_magnitude;
  return worst_ratio();
}

/// One linear solve about the present graph points; moves c, z and xi.
InequalityEngine::Outcome InequalityEngine::newton_step() {
  for (int p = 0; p < n_points; ++p) { // xi at the present z on the linearised graph
    Small v = at(z, p);
    const Small base = at(z_hat, p), x0 = at(xi_hat, p);
    for (int i = 0; i < 3; ++i) v[i] -= base[i];
    v = apply_d(p, v);
    put(xi, p, {x0[0] + v[0], x0[1] + v[1], x0[2] + v[2]});
  }
  gather(xi);
  residual = *rhs - sc - force;
  have_s_dc = false;
  if (!solve_linear()) return Outcome::indefinite;
  if (!dc.allFinite()) return Outcome::failed;
  ++report.iterations;
  const bool known = have_s_dc && c == c_of_product;
  c += dc;
  if (known) sc += s_dc, c_of_product = c, have_magnitude = false;
  dz.noalias() = problem.g * dc;
  // By the increment, not from z - z_hat again: a held point's z is exact only up to rounding,
  // which its large stiffness would turn into an error of xi.
  for (int p = 0; p < n_points; ++p) {
    const Small v = apply_d(p, at(dz, p)), x0 = at(xi, p);
    put(xi, p, {x0[0] + v[0], x0[1] + v[1], x0[2] + v[2]});
    if (points[p].exclusive && resting(p)) take_rest(p);
  }
  update_z();
  return Outcome::solved;
}

/// Residual of the problem with the multipliers that belong to the present z (in `trial`). Points
/// that rest and have their unknowns to themselves take what their equations leave them, exactly.
double InequalityEngine::try_multipliers() {
  update_product();
  update_reach();
  for (int p = 0; p < n_points; ++p) put(trial, p, multiplier(p));
  const double ratio = residual_ratio(trial);
  bool balanced = false;
  for (int p = 0; p < n_points; ++p)
    if (points[p].exclusive && resting(p)) balanced = balance(p) || balanced;
  return balanced ? residual_ratio(trial) : ratio;
}

// A cycle among the same states is left by weighing z against xi differently.
constexpr double other_scales[] = {0.1, 10.0, 0.01};

InequalityEngine::Outcome InequalityEngine::newton(int limit) {
  std::unordered_map<std::uint64_t, int> seen;
  double best = std::numeric_limits<double>::infinity(), shrink = 1.0;
  int tries = 0;
  settled = false;
  update_product();
  for (int k = 0; k < limit; ++k) {
    if (const Outcome step = newton_step(); step != Outcome::solved) return step;
    states_before = state;
    for (int p = 0; p < n_points; ++p) classify(p, shrink);
    settled = state == states_before;
    for (int p = 0; p < n_points; ++p) settle(p);
    update_z();
    snap_factor = k < 8 ? tight_snap : certificate_snap;
    const double ratio = try_multipliers();
    if (ratio <= target() || (ratio <= options.tolerance && ratio > 0.25 * best)) {
      xi = trial;
      return Outcome::solved;
    }
    if (ratio > 0.5 * best && ++seen[hash_of(state, xi_hat)] > 1) {
      if (tries == static_cast<int>(std::size(other_scales))) return Outcome::failed;
      shrink = other_scales[tries++];
      seen.clear();
    }
    best = std::min(best, ratio);
  }
  return Outcome::failed;
}

} // namespace hvi::solver
