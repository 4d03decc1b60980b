// Semismooth Newton on graph states (active_set.hpp).
//
// Each point stands on a point (z_hat, xi_hat) of its component's graph with a stiffness D. One
// step solves  (S + sum w G^T D G) dc = r - S c - G^T W (xi_hat + D (z - z_hat)), and the resolvent
// of z + gamma (xi + m z) gives every point its next place. When the places stay, what is left is
// Newton's method for smooth slopes; with affine pieces the first step is exact.
#include "solver/inequality/active_set.hpp"

#include "solver/inequality/multipliers.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace hvi::solver {

namespace {

/// Of the states and the signs of xi: a radial point of one row that slips to and fro keeps its
/// state, and only the sign shows that it turned.
std::uint64_t hash_of(const std::vector<int>& state, const Vector& xi_hat) {
  std::uint64_t h = 1469598103934665603ULL;
  const auto mix = [&](int v) { h = (h ^ static_cast<std::uint64_t>(v + 1)) * 1099511628211ULL; };
  for (const int v : state) mix(v);
  for (const double v : xi_hat) mix(v < 0.0 ? 1 : 2);
  return h;
}

/// Adds to the multiplier of a resting point the residual that conjugate gradients left in its
/// equations.
void take_rest(const ContactPoints& points, int p, const Vector& rest, Vector& xi) {
  const PointData& q = points[p];
  for (int k = 0; k < q.rows; ++k)
    for (SparseMatrix::InnerIterator it(points.g, q.first + k); it; ++it)
      if (it.value() != 0.0)
        xi[q.first + k] += rest[it.col()] / (q.weight * q.share[k] * it.value());
}

// Factors of gamma, tried in turn where the iteration goes round among the same states.
constexpr double other_scales[] = {0.1, 10.0, 0.01};

} // namespace

ActiveSetNewton::ActiveSetNewton(TangentSolver& tangent, const InequalityOptions& options)
    : tangent_(tangent), options_(options) {}

/// One linear solve about the present graph points; moves c, z and xi.
MethodOutcome ActiveSetNewton::step(Position& at, bool settled, InequalityReport& report) {
  const ContactPoints& points = at.points;
  for (int p = 0; p < points.size(); ++p) points[p].put(at.xi, at.places.on_tangent(p, at.z));
  at.balance.product.update(at.c);
  const Vector& residual = at.balance.residual(at.xi);
  if (!tangent_.solve(at, residual, settled, report, step_)) return MethodOutcome::indefinite;
  if (!step_.dc.allFinite()) return MethodOutcome::failed;
  ++report.iterations;
  at.c += step_.dc;
  if (step_.product_known) {
    at.balance.product.shift(step_.s_dc);
    at.balance.product.belongs_to(at.c);
  }
  dz_.noalias() = points.g * step_.dc;
  // By the increment, not from z - z_hat again: a held point's z is exact only up to rounding,
  // which its large stiffness would turn into an error of xi.
  for (int p = 0; p < points.size(); ++p) {
    const PointData& q = points[p];
    q.put(at.xi, q.of(at.xi) + at.places.times_stiffness(p, q.of(dz_)));
    if (q.exclusive && at.places.resting(p)) take_rest(points, p, step_.rest, at.xi);
  }
  at.update_arguments();
  return MethodOutcome::solved;
}

MethodOutcome ActiveSetNewton::solve(Position& at, int limit, InequalityReport& report) {
  std::unordered_map<std::uint64_t, int> seen;
  double best = std::numeric_limits<double>::infinity(), shrink = 1.0;
  int tries = 0;
  bool settled = false;
  for (int k = 0; k < limit; ++k) {
    if (options_.before_iteration) options_.before_iteration();
    if (const auto outcome = step(at, settled, report); outcome != MethodOutcome::solved)
      return outcome;
    state_before_ = at.places.state;
    at.classify(shrink);
    settled = at.places.state == state_before_;
    for (int p = 0; p < at.points.size(); ++p) at.places.settle(p, at.c);
    at.update_arguments();
    const double ratio = certain_multipliers(at, k < 8 ? Snap::tight : Snap::certificate, trial_);
    if (ratio <= at.balance.target() || (ratio <= options_.tolerance && ratio > 0.25 * best)) {
      at.xi = trial_;
      return MethodOutcome::solved;
    }
    // While ever smaller rows are solved for, one step for each size, the worst error stays that of
    // the smallest: no sign that the iteration goes round.
    const bool round = ratio > 0.5 * best && !step_.of_small_rows;
    if (round && ++seen[hash_of(at.places.state, at.places.xi_hat)] > 1) {
      if (tries == static_cast<int>(std::size(other_scales))) return MethodOutcome::failed;
      shrink = other_scales[tries++];
      seen.clear();
    }
    best = std::min(best, ratio);
  }
  return MethodOutcome::failed;
}

} // namespace hvi::solver
