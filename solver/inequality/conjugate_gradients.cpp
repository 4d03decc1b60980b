// Conjugate gradients around the last factor (conjugate_gradients.hpp).
#include "solver/inequality/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// When each solve takes more iterations than this, a new factor costs less within a few steps.
constexpr int many_iterations = 6;
/// Iterations that a solve may take beyond what they cost less than a factor: it serves later ones.
constexpr int more_iterations = 3;
/// Below this size a factor costs next to nothing.
constexpr int worth_iterating = 64;

/// So many unknowns of far points cost less than a factor: as many as the products and solves that
/// it is worth, or, while they are few, an eighth of all, whose columns take n^3/4 operations and
/// serve several steps.
std::size_t most_far_unknowns(const ReducedOperator& op) {
  constexpr int few = 64;
  return static_cast<std::size_t>(std::max(5 * op.patience(), std::min(op.size() / 8, few)));
}

} // namespace

ConjugateGradients::ConjugateGradients(const ContactPoints& points, const StiffnessPattern& pattern,
                                       LastFactor& factor)
    : points_(points), pattern_(pattern), factor_(factor), preconditioner_(points, factor),
      h_(pattern.zero()), drift_(pattern.zero()) {}

void ConjugateGradients::restore(int last_iterations, FarColumns columns, int served) {
  last_ = last_iterations;
  preconditioner_.restore(std::move(columns), served);
}

/// Makes H, E and the preconditioner when the last factor is close to S + H.
bool ConjugateGradients::is_close(const PointMatrices& d) {
  const ReducedOperator& op = factor_.op();
  if (!factor_.made() || !op.symmetric() || points_.unknowns < worth_iterating) return false;
  if (last_ > std::max(many_iterations, op.patience() / 2)) return last_ = 0, false;
  const std::size_t most = most_far_unknowns(op);
  const PointMatrices& factored = factor_.stiffnesses();
  if (!find_far_points(points_, d, factored, most, far_)) return false;
  if (preconditioner_.columns().size() > 4 * most) return false;
  pattern_.assemble(d, h_);
  StiffnessPattern::clear(drift_);
  change_ = d;
  for (std::size_t k = 0; k < d.size(); ++k) change_[k] -= factored[k];
  for (int p = 0; p < points_.size(); ++p) {
    const auto moved = points_[p].block(change_);
    if (far_.is_far[p] == 0 && std::ranges::any_of(moved, [](double v) { return v != 0.0; }))
      pattern_.add(p, moved, drift_);
  }
  return preconditioner_.prepare(far_, h_);
}

bool ConjugateGradients::solve(const Position& at, const Vector& residual, bool settled,
                               InequalityReport& report, TangentStep& out) {
  preconditioner_.keep_up();
  const PointMatrices& d = at.places.d;
  const bool same = factor_.is_of(d);
  if (!same && is_close(d) && iterate(residual, settled, out))
    return finish_inexact(at, factor_.op(), h_, residual, out), true;
  if (!factor_.make(d, report)) return false;
  if (!same && !at.idle && factor_.op().rounded()) { // the next step of Newton's refines it
    preconditioner_.keep_up();
    StiffnessPattern::clear(drift_);
    if (preconditioner_.prepare({}, drift_) && iterate(residual, settled, out)) {
      pattern_.assemble(d, h_);
      return finish_inexact(at, factor_.op(), h_, residual, out), true;
    }
  }
  return factor_.solve(at, residual, settled, report, out);
}

bool ConjugateGradients::iterate(const Vector& residual, bool settled, TangentStep& out) {
  Vector &r = r_, &z = z_, &p = p_, &mp = mp_, &q = q_; // mp: P times the direction p
  r = residual;
  preconditioner_.apply(r, z);
  // Inner products of forces with displacements, scaled so that no unit system overflows.
  const double unit = z.lpNorm<Eigen::Infinity>(), unit_r = r.lpNorm<Eigen::Infinity>();
  if (!(unit > 0.0) || !(unit_r > 0.0) || !std::isfinite(unit)) return false;
  const auto product = [&](const Vector& a, const Vector& b) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < a.size(); ++i) sum += (a[i] / unit_r) * (b[i] / unit);
    return sum;
  };
  out.dc.setZero(r.size());
  p = z, mp = r;
  double rho = product(r, z);
  // Five digits of the error's energy norm; three while points still change their places. With one
  // digit less Newton's steps are more than the iterations that it spares are worth.
  const double enough = (settled ? 1e-10 : 1e-6) * rho;
  for (int k = 0; k < factor_.op().patience() + more_iterations; ++k) {
    last_ = k + 1;
    q = mp;
    q.noalias() += drift_ * p;
    const double curvature = product(q, p);
    if (!(curvature > 0.0)) return false;
    const double step = rho / curvature;
    out.dc += step * p, r -= step * q;
    preconditioner_.apply(r, z);
    const double next = product(r, z);
    if (!(next >= 0.0)) return false;
    if (next <= enough) return true;
    p = z + (next / rho) * p;
    mp = r + (next / rho) * mp;
    rho = next;
  }
  return false;
}

void finish_inexact(const Position& at, const ReducedOperator& s, const SparseMatrix& h,
                    const Vector& residual, TangentStep& out) {
  const ContactPoints& points = at.points;
  for (int p = 0; p < points.size(); ++p) {
    const PointData& q = points[p];
    if (!q.exclusive || !at.places.resting(p) || q.of(at.z) != q.of(at.places.z_hat)) continue;
    for (int row = q.first; row < q.first + q.rows; ++row)
      for (SparseMatrix::InnerIterator it(points.g, row); it; ++it)
        if (it.value() != 0.0) out.dc[it.col()] = 0.0;
  }
  s.apply(out.dc, out.s_dc);
  out.product_known = true;
  out.rest = residual - out.s_dc;
  out.rest.noalias() -= h * out.dc;
}

} // namespace hvi::solver
