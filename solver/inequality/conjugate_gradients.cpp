// Linear solves of Newton's steps without a new factor (engine.hpp).
//
// The last factor M = S + H_old preconditions S + H. Most points keep their stiffness about; those
// that moved far (stick to slip and back) are few and have their unknowns to themselves. With Q the
// far unknowns that got stiffer, R those that got softer, E_X the restriction to X,
//     P^-1 = (1 - E_Q) M^-1 (1 - E_Q) + E_Q diag(S + H)^-1 E_Q + E_R (S + H)_RR^-1 E_R,
// symmetric and positive definite. A front of a hundred points that begin to slip costs four
// iterations instead of a factor.
#include "solver/inequality/engine.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// A factor pays for itself over the solves of a few steps when each takes more than this.
constexpr int many_iterations = 6;

double size_of(const std::array<double, 9>& m) { return std::abs(m[0]) + m[4] + m[8]; }

} // namespace

/// Lists the points whose stiffness moved far from the factored one, by the body's own. False when
/// one of them shares its unknowns, or when they are too many for this to pay.
bool InequalityEngine::factor_is_close() {
  far.clear();
  if (!factored || !op.symmetric()) return false;
  const auto most = static_cast<std::size_t>(5 * op.patience());
  if (last_cg > many_iterations) return last_cg = 0, false;
  for (int p = 0; p < n_points; ++p) {
    bool close = true;
    for (int k = 0; k < 9; ++k)
      close = close && std::abs(d[p][k] - d_factored[p][k]) * points[p].local <= 10.0;
    if (close) continue;
    if (!points[p].exclusive || far.size() >= most) return false;
    far.push_back({p, size_of(d[p]) > size_of(d_factored[p])});
  }
  assemble();
  factor_block();
  return block_factor.info() == Eigen::Success;
}

/// The far unknowns that got softer, and the factor of S + H on them. Those that got stiffer keep
/// the inverse of their own diagonal entries only: they hardly move.
void InequalityEngine::factor_block() {
  block_unknowns.clear(), stiff_unknowns.clear();
  for (const FarPoint& f : far)
    for (int k = 0; k < points[f.point].rows; ++k)
      for (SparseMatrix::InnerIterator it(problem.g, points[f.point].first + k); it; ++it)
        if (it.value() != 0.0)
          (f.stiffer ? stiff_unknowns : block_unknowns).push_back(static_cast<int>(it.col()));
  const auto m = static_cast<int>(block_unknowns.size());
  block.resize(m, m);
  block_unit = 0.0; // by the body's own stiffness: no unit system overflows in the factor
  for (const int i : block_unknowns) block_unit = std::max(block_unit, std::abs(diagonal[i]));
  for (int b = 0; b < m; ++b)
    for (int a = b; a < m; ++a)
      block(a, b) = op.entry(block_unknowns[a], block_unknowns[b]) / block_unit;
  // H couples the unknowns of one point only: they stand next to each other, at most three.
  for (int b = 0; b < m; ++b)
    for (int a = b; a < std::min(b + 3, m); ++a)
      block(a, b) += h.coeff(block_unknowns[a], block_unknowns[b]) / block_unit;
  block_factor.compute(block);
  block_work.resize(m);
}

/// out = P^-1 r
void InequalityEngine::precondition(const Vector& r, Vector& out) {
  if (far.empty()) return op.solve(r, out);
  cg_kept = r;
  for (const int i : stiff_unknowns) cg_kept[i] = 0.0;
  op.solve(cg_kept, out);
  for (const int i : stiff_unknowns) out[i] = r[i] / (diagonal[i] + h.coeff(i, i));
  const auto m = static_cast<int>(block_unknowns.size());
  for (int a = 0; a < m; ++a) block_work[a] = r[block_unknowns[a]] / block_unit;
  block_factor.solveInPlace(block_work);
  for (int a = 0; a < m; ++a) out[block_unknowns[a]] += block_work[a];
}

bool InequalityEngine::conjugate_gradients() {
  cg_r = residual;
  precondition(cg_r, cg_z);
  // Inner products of forces with displacements, scaled so that no unit system overflows.
  const double unit = cg_z.lpNorm<Eigen::Infinity>(), unit_r = cg_r.lpNorm<Eigen::Infinity>();
  if (!(unit > 0.0) || !(unit_r > 0.0) || !std::isfinite(unit)) return false;
  const auto product = [&](const Vector& a, const Vector& b) {
    double sum = 0.0;
    for (int i = 0; i < n; ++i) sum += (a[i] / unit_r) * (b[i] / unit);
    return sum;
  };
  dc.setZero(), cg_p = cg_z;
  double rho = product(cg_r, cg_z);
  // Three digits of the error's energy norm; two while points still change sides.
  const double enough = (far.empty() ? 1e-6 : 1e-4) * rho;
  for (int k = 0; k < op.patience(); ++k) {
    last_cg = k + 1;
    op.apply(cg_p, cg_q);
    cg_q.noalias() += h * cg_p;
    const double curvature = product(cg_q, cg_p);
    if (!(curvature > 0.0)) return false;
    const double step = rho / curvature;
    dc += step * cg_p, cg_r -= step * cg_q;
    precondition(cg_r, cg_z);
    const double next = product(cg_r, cg_z);
    if (!(next >= 0.0)) return false;
    if (next <= enough) return true;
    cg_p = cg_z + (next / rho) * cg_p;
    rho = next;
  }
  return false;
}

/// What conjugate gradients left of the equations of a resting point belongs to its multiplier.
void InequalityEngine::take_rest(int p) {
  const PointData& q = points[p];
  for (int k = 0; k < q.rows; ++k)
    for (SparseMatrix::InnerIterator it(problem.g, q.first + k); it; ++it)
      if (it.value() != 0.0) xi[q.first + k] += cg_r[it.col()] / (q.weight * it.value());
}

} // namespace hvi::solver
