// Linear solves of Newton's steps without a new factor (engine.hpp).
//
// The last factor M = S + H_old preconditions S + H. Most points keep their stiffness about; those
// that moved far (stick to slip and back, contact that opens) are few and have their unknowns to
// themselves. With X their unknowns, the preconditioner is the matrix P that equals S + H on X and
// M elsewhere, solved exactly:
//
//   R: unknowns that M holds by a penalty and that are free now. M^-1 gives 0 there, so that with
//      Y = M^-1 S E_R and C = (S + H)_RR - S_RF Y   (F: all but R)
//          x_R = C^-1 (b_R - Y^T b),   x_F = M^-1 b - Y x_R.
//   Q: the others, by Woodbury with Delta = (H - H_old)_QQ and Z = M^-1 E_Q:
//          force = (1 + Delta G)^-1 Delta x_Q,   G = Z_QQ + Y_Q C^-1 Y_Q^T,   b := b - E_Q force.
//
// The columns Y and Z are kept as long as the factor. What is left to conjugate gradients are the
// small changes of slopes, E = S + H - P: a few iterations. They need no product with S, for P p is
// known of a direction p = P^-1 r + beta p_before: it is r + beta P p_before.
#include "solver/inequality/engine.hpp"

#include <cblas.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

// OpenBLAS: Eigen's own products are compiled for any processor.

/// y += alpha A x, or alpha A^T x.
void add_product(CBLAS_TRANSPOSE trans, double alpha, const DenseMatrix& a, const Vector& x,
                 Vector& y) {
  const int rows = static_cast<int>(a.rows()), columns = static_cast<int>(a.cols());
  if (rows == 0 || columns == 0) return;
  cblas_dgemv(CblasColMajor, trans, rows, columns, alpha, a.data(), rows, x.data(), 1, 1.0,
              y.data(), 1);
}

/// A^T B
DenseMatrix inner(const DenseMatrix& a, const DenseMatrix& b) {
  const int rows = static_cast<int>(a.rows()), m = static_cast<int>(a.cols()),
            k = static_cast<int>(b.cols());
  DenseMatrix out(m, k);
  if (m > 0 && k > 0)
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, m, k, rows, 1.0, a.data(), rows, b.data(),
                rows, 0.0, out.data(), m);
  return out;
}

/// A factor pays for itself over the solves of a few steps when each takes more than this.
constexpr int many_iterations = 6;
/// Below this size a factor costs next to nothing.
constexpr int worth_iterating = 64;
/// A stiffness that moved by more than this, by the body's own, is far from the factored one.
constexpr double far_away = 2.0;
/// Stiffness over that of the body: beyond it a point counts as held.
constexpr double holds = 1e6;

/// Are all rows of a point held alike? (At the origin, or at a break of a scalar law.)
bool holds_all(const std::array<double, 9>& m, int rows, double local) {
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < rows; ++j) {
      const double v = m[3 * i + j];
      if (i == j ? !(v * local > holds) : v != 0.0) return false;
    }
  return true;
}

bool holds_some(const std::array<double, 9>& m, double local) {
  return std::any_of(m.begin(), m.end(), [&](double v) { return std::abs(v) * local > holds; });
}

} // namespace

/// Lists the points whose stiffness moved far from the factored one, by the body's own. False when
/// one of them shares its unknowns, or when they are too many for this to pay.
bool InequalityEngine::factor_is_close() {
  if (!factored || !op.symmetric() || n < worth_iterating) return false;
  if (last_cg > std::max(many_iterations, op.patience() / 2)) return last_cg = 0, false;
  freed.clear(), changed.clear(), delta.clear();
  const auto most = static_cast<std::size_t>(5 * op.patience());
  for (int p = 0; p < n_points; ++p) {
    bool close = true;
    for (int k = 0; k < 9; ++k)
      close = close && std::abs(d[p][k] - d_factored[p][k]) * points[p].local <= far_away;
    far_point[p] = !close;
    if (close) continue;
    if (!points[p].exclusive || !add_far(p)) return false;
    if (freed.size() + changed.size() > most) return false;
  }
  if (far_columns.size() > 4 * most) return false;
  assemble();
  prepare_drift();
  return prepare_far();
}

/// E = S + H - P: far points have their stiffness in P.
void InequalityEngine::prepare_drift() {
  double* values = drift.valuePtr();
  std::fill(values, values + drift.nonZeros(), 0.0);
  for (int p = 0; p < n_points; ++p) {
    if (far_point[p] != 0 || d[p] == d_factored[p]) continue;
    for (int k = first_contribution[p]; k < first_contribution[p + 1]; ++k) {
      const Contribution& q = contributions[k];
      values[q.value] += q.coefficient * (d[p][q.entry] - d_factored[p][q.entry]);
    }
  }
}

/// Unknowns of points that are held in all rows by d_factored and have them to themselves: no
/// factor needs them.
std::span<const int> InequalityEngine::held_unknowns() {
  left_out.clear();
  for (int p = 0; p < n_points; ++p) {
    const PointData& q = points[p];
    if (!q.exclusive || !holds_all(d_factored[p], q.rows, q.local)) continue;
    for (int row = q.first; row < q.first + q.rows; ++row)
      for (SparseMatrix::InnerIterator it(problem.g, row); it; ++it)
        if (it.value() != 0.0) left_out.push_back(static_cast<int>(it.col()));
  }
  std::sort(left_out.begin(), left_out.end());
  return left_out;
}

/// Puts the unknowns of a far point among the freed or the changed ones.
bool InequalityEngine::add_far(int p) {
  const PointData& q = points[p];
  const bool held = holds_all(d_factored[p], q.rows, q.local);
  if (!held && holds_some(d_factored[p], q.local)) return false; // held along one direction
  int unknown[3] = {};
  double g[3] = {};
  for (int a = 0; a < q.rows; ++a)
    for (SparseMatrix::InnerIterator it(problem.g, q.first + a); it; ++it)
      if (it.value() != 0.0) unknown[a] = static_cast<int>(it.col()), g[a] = it.value();
  for (int a = 0; a < q.rows; ++a) {
    if (held) {
      freed.push_back(unknown[a]);
      continue;
    }
    const bool now_held = holds_all(d[p], q.rows, q.local);
    for (int b = 0; b < q.rows; ++b) {
      const double change = d[p][3 * a + b] - d_factored[p][3 * a + b];
      const auto row = static_cast<int>(changed.size());
      delta.push_back({row, row - a + b, q.weight * g[a] * g[b] * change, now_held && a == b});
    }
    changed.push_back(unknown[a]);
  }
  return true;
}

/// M^-1 S e_i for a freed unknown, M^-1 e_i for a changed one: those not known yet in one go.
void InequalityEngine::solve_far_columns() {
  std::vector<int> missing;
  for (const int i : freed)
    if (!far_columns.contains(i)) missing.push_back(i);
  const auto first_changed = static_cast<int>(missing.size());
  for (const int i : changed)
    if (!far_columns.contains(i)) missing.push_back(i);
  if (missing.empty()) return;
  DenseMatrix columns = DenseMatrix::Zero(n, static_cast<Eigen::Index>(missing.size()));
  for (int j = 0; j < static_cast<int>(missing.size()); ++j) {
    if (j >= first_changed)
      columns(missing[j], j) = 1.0;
    else
      op.column(missing[j], &columns(0, j));
  }
  op.solve_rough(columns);
  for (std::size_t j = 0; j < missing.size(); ++j)
    far_columns[missing[j]] = columns.col(static_cast<Eigen::Index>(j));
}

void InequalityEngine::forget_far() {
  preconditioned = 0;
  far_columns.clear();
  freed_before.clear();
  far_y.resize(n, 0);
  freed_block.resize(0, 0);
}

/// Y with its rows R set to 0, and S_RR - S_RF Y, over the body's own stiffness: no unit system
/// overflows. As they are while R and the factor stay.
void InequalityEngine::prepare_freed() {
  if (freed == freed_before) return;
  freed_before = freed;
  const auto m = static_cast<Eigen::Index>(freed.size());
  far_y.resize(n, m);
  DenseMatrix rows(n, m);
  for (Eigen::Index j = 0; j < m; ++j) {
    far_y.col(j) = far_columns.at(freed[j]);
    for (const int i : freed) far_y(i, j) = 0.0;
    op.column(freed[j], &rows(0, j));
  }
  rows /= block_unit;
  freed_block = -inner(rows, far_y);
  for (Eigen::Index b = 0; b < m; ++b)
    for (Eigen::Index a = 0; a < m; ++a) freed_block(a, b) += rows(freed[a], b);
}

/// C and 1 + Delta G with their factors.
bool InequalityEngine::prepare_far() {
  const auto m = static_cast<Eigen::Index>(freed.size());
  const auto k = static_cast<Eigen::Index>(changed.size());
  if (m + k == 0) return true;
  solve_far_columns();
  block_unit = diagonal.cwiseAbs().maxCoeff();
  if (!(block_unit > 0.0)) return false;
  prepare_freed();
  DenseMatrix c_block = freed_block;
  // H couples the unknowns of one point only: they stand next to each other, at most three.
  for (Eigen::Index b = 0; b < m; ++b)
    for (Eigen::Index a = std::max<Eigen::Index>(0, b - 2); a < std::min(b + 3, m); ++a)
      c_block(a, b) += h.coeff(freed[a], freed[b]) / block_unit;
  freed_factor.compute(c_block);
  if (m > 0 && freed_factor.info() != Eigen::Success) return false;
  if (k == 0) return true;
  far_z.resize(n, k);
  for (Eigen::Index j = 0; j < k; ++j) far_z.col(j) = far_columns.at(changed[j]);
  DenseMatrix y_q(k, m), g(k, k);
  for (Eigen::Index a = 0; a < k; ++a) y_q.row(a) = far_y.row(changed[a]);
  for (Eigen::Index a = 0; a < k; ++a) g.row(a) = far_z.row(changed[a]);
  if (m > 0) g += y_q * freed_factor.solve(y_q.transpose()) / block_unit;
  DenseMatrix w = DenseMatrix::Identity(k, k);
  for (const auto& e : delta) w.row(e.row) += e.value * g.row(e.column);
  changed_factor.compute(w);
  far_y_q = y_q;
  return true;
}

/// out = P^-1 r
void InequalityEngine::precondition(const Vector& r, Vector& out) {
  if (++preconditioned == served_long) op.expect_rough_solves();
  if (freed.empty() && changed.empty()) return op.solve_rough(r, out);
  const auto m = static_cast<Eigen::Index>(freed.size());
  const auto k = static_cast<Eigen::Index>(changed.size());
  cg_kept = r;
  for (const int i : freed) cg_kept[i] = 0.0;
  op.solve_rough(cg_kept, out);
  far_t.resize(m);
  for (Eigen::Index j = 0; j < m; ++j) far_t[j] = r[freed[j]];
  add_product(CblasTrans, -1.0, far_y, cg_kept, far_t);
  if (k > 0) {
    far_x.resize(k);
    for (Eigen::Index j = 0; j < k; ++j) far_x[j] = out[changed[j]];
    if (m > 0) {
      far_free = far_t / block_unit;
      freed_factor.solveInPlace(far_free);
      far_x.noalias() -= far_y_q * far_free;
    }
    far_pull.setZero(k);
    for (const auto& e : delta) far_pull[e.row] += e.value * far_x[e.column];
    far_force.resize(k);
    far_force = changed_factor.solve(far_pull);
    far_t.noalias() += far_y_q.transpose() * far_force;
    add_product(CblasNoTrans, -1.0, far_z, far_force, out);
    // A held unknown moves by force / stiffness: the difference above would be rounding.
    for (const auto& e : delta)
      if (e.held) out[changed[e.row]] = far_force[e.row] / e.value;
  }
  if (m == 0) return;
  far_free = far_t / block_unit;
  freed_factor.solveInPlace(far_free);
  add_product(CblasNoTrans, -1.0, far_y, far_free, out);
  for (Eigen::Index j = 0; j < m; ++j) out[freed[j]] = far_free[j];
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
  dc.setZero(), cg_p = cg_z, cg_mp = cg_r;
  double rho = product(cg_r, cg_z);
  // Four digits of the error's energy norm; two while points still change their places.
  const double enough = (settled ? 1e-8 : 1e-4) * rho;
  for (int k = 0; k < op.patience(); ++k) {
    last_cg = k + 1;
    cg_q = cg_mp;
    cg_q.noalias() += drift * cg_p;
    const double curvature = product(cg_q, cg_p);
    if (!(curvature > 0.0)) return false;
    const double step = rho / curvature;
    dc += step * cg_p, cg_r -= step * cg_q;
    precondition(cg_r, cg_z);
    const double next = product(cg_r, cg_z);
    if (!(next >= 0.0)) return false;
    if (next <= enough) return accept_direction(), true;
    cg_p = cg_z + (next / rho) * cg_p;
    cg_mp = cg_r + (next / rho) * cg_mp;
    rho = next;
  }
  return false;
}

/// What is really left of the residual: points that rest take it. Those that stand where they are
/// held do not move at all, so that S c need not be formed anew.
void InequalityEngine::accept_direction() {
  for (int p = 0; p < n_points; ++p) {
    if (!points[p].exclusive || !resting(p) || at(z, p) != at(z_hat, p)) continue;
    for (int row = points[p].first; row < points[p].first + points[p].rows; ++row)
      for (SparseMatrix::InnerIterator it(problem.g, row); it; ++it)
        if (it.value() != 0.0) dc[it.col()] = 0.0;
  }
  op.apply(dc, s_dc);
  have_s_dc = true;
  cg_r = residual - s_dc;
  cg_r.noalias() -= h * dc;
}

/// What conjugate gradients left of the equations of a resting point belongs to its multiplier.
void InequalityEngine::take_rest(int p) {
  const PointData& q = points[p];
  for (int k = 0; k < q.rows; ++k)
    for (SparseMatrix::InnerIterator it(problem.g, q.first + k); it; ++it)
      if (it.value() != 0.0) xi[q.first + k] += cg_r[it.col()] / (q.weight * it.value());
}

} // namespace hvi::solver
