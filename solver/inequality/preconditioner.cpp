// The corrected factor (preconditioner.hpp).
#include "solver/inequality/preconditioner.hpp"

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

/// v at some of its entries.
Vector entries(const Vector& v, const std::vector<int>& at) {
  Vector out(static_cast<Eigen::Index>(at.size()));
  for (std::size_t j = 0; j < at.size(); ++j) out[static_cast<Eigen::Index>(j)] = v[at[j]];
  return out;
}

/// A stiffness that moved by more than this, by the body's own, is far from the factored one.
constexpr double far_away = 2.0;
/// A factor that has served so often serves on: the slopes change little.
constexpr int served_long = 16;

bool holds_some(const SmallMatrix& d, const PointData& q) {
  return std::any_of(d.begin(), d.end(),
                     [&](double v) { return std::abs(v) * q.local > holding_stiffness; });
}

/// Puts the unknowns of a far point, which has them to itself, among the freed or the changed ones.
/// False: the factor holds it along one direction.
bool add_far(const ContactPoints& points, int p, const SmallMatrix& d,
             const SmallMatrix& d_factored, FarPoints& out) {
  const PointData& q = points[p];
  const bool held = holds_all(d_factored, q);
  if (!held && holds_some(d_factored, q)) return false;
  int unknown[3] = {};
  double g[3] = {};
  for (int a = 0; a < q.rows; ++a)
    for (SparseMatrix::InnerIterator it(points.problem.g, q.first + a); it; ++it)
      if (it.value() != 0.0) unknown[a] = static_cast<int>(it.col()), g[a] = it.value();
  const bool now_held = holds_all(d, q);
  for (int a = 0; a < q.rows; ++a) {
    if (held) {
      out.freed.push_back(unknown[a]);
      continue;
    }
    for (int b = 0; b < q.rows; ++b) {
      const double change = d[3 * a + b] - d_factored[3 * a + b];
      const auto row = static_cast<int>(out.changed.size());
      out.delta.push_back({row, row - a + b, q.weight * g[a] * g[b] * change, now_held && a == b});
    }
    out.changed.push_back(unknown[a]);
  }
  return true;
}

} // namespace

bool find_far_points(const ContactPoints& points, const std::vector<SmallMatrix>& d,
                     const std::vector<SmallMatrix>& d_factored, std::size_t most, FarPoints& out) {
  out.freed.clear(), out.changed.clear(), out.delta.clear();
  out.is_far.resize(d.size());
  for (int p = 0; p < points.size(); ++p) {
    bool close = true;
    for (int k = 0; k < 9; ++k)
      close = close && std::abs(d[p][k] - d_factored[p][k]) * points[p].local <= far_away;
    out.is_far[p] = !close;
    if (close) continue;
    if (!points[p].exclusive || !add_far(points, p, d[p], d_factored[p], out)) return false;
    if (out.unknowns() > most) return false;
  }
  return true;
}

Preconditioner::Preconditioner(const ContactPoints& points, LastFactor& factor)
    : points_(points), factor_(factor) {}

void Preconditioner::keep_up() {
  if (number_ == factor_.number()) return;
  number_ = factor_.number();
  served_ = 0;
  columns_.clear();
  freed_.unknowns.clear();
  freed_.y.resize(points_.unknowns, 0);
  freed_.block.resize(0, 0);
}

const Preconditioner::Columns& Preconditioner::columns() const {
  static const Columns none;
  return number_ == factor_.number() ? columns_ : none;
}

int Preconditioner::served() const { return number_ == factor_.number() ? served_ : 0; }

void Preconditioner::restore(Columns columns, int served) {
  keep_up();
  columns_ = std::move(columns);
  served_ = served;
  if (served_ >= served_long) factor_.op().expect_rough_solves();
}

/// M^-1 S e_i for a freed unknown, M^-1 e_i for a changed one: those not known yet in one go.
void Preconditioner::solve_columns() {
  std::vector<int> missing;
  for (const int i : far_.freed)
    if (!columns_.contains(i)) missing.push_back(i);
  const auto first_changed = static_cast<int>(missing.size());
  for (const int i : far_.changed)
    if (!columns_.contains(i)) missing.push_back(i);
  if (missing.empty()) return;
  DenseMatrix columns =
      DenseMatrix::Zero(points_.unknowns, static_cast<Eigen::Index>(missing.size()));
  for (int j = 0; j < static_cast<int>(missing.size()); ++j) {
    if (j >= first_changed)
      columns(missing[j], j) = 1.0;
    else
      factor_.op().column(missing[j], &columns(0, j));
  }
  factor_.op().solve_rough(columns);
  for (std::size_t j = 0; j < missing.size(); ++j)
    columns_[missing[j]] = columns.col(static_cast<Eigen::Index>(j));
}

/// As they are while R and the factor stay.
void Preconditioner::prepare_freed() {
  const std::vector<int>& freed = far_.freed;
  if (freed == freed_.unknowns) return;
  freed_.unknowns = freed;
  const auto m = static_cast<Eigen::Index>(freed.size());
  freed_.y.resize(points_.unknowns, m);
  DenseMatrix rows(points_.unknowns, m);
  for (Eigen::Index j = 0; j < m; ++j) {
    freed_.y.col(j) = columns_.at(freed[j]);
    for (const int i : freed) freed_.y(i, j) = 0.0;
    factor_.op().column(freed[j], &rows(0, j));
  }
  rows /= unit_;
  freed_.block = -inner(rows, freed_.y);
  for (Eigen::Index b = 0; b < m; ++b)
    for (Eigen::Index a = 0; a < m; ++a) freed_.block(a, b) += rows(freed[a], b);
}

/// 1 + Delta G with its factor.
void Preconditioner::prepare_changed() {
  const std::vector<int>& changed = far_.changed;
  const auto k = static_cast<Eigen::Index>(changed.size());
  changed_.z.resize(points_.unknowns, k);
  for (Eigen::Index j = 0; j < k; ++j) changed_.z.col(j) = columns_.at(changed[j]);
  DenseMatrix y_rows(k, freed_.y.cols()), g(k, k);
  for (Eigen::Index a = 0; a < k; ++a) y_rows.row(a) = freed_.y.row(changed[a]);
  for (Eigen::Index a = 0; a < k; ++a) g.row(a) = changed_.z.row(changed[a]);
  if (!far_.freed.empty()) g += y_rows * freed_.factor.solve(y_rows.transpose()) / unit_;
  DenseMatrix w = DenseMatrix::Identity(k, k);
  for (const auto& e : far_.delta) w.row(e.row) += e.value * g.row(e.column);
  changed_.factor.compute(w);
  changed_.y_rows = y_rows;
}

bool Preconditioner::prepare(const FarPoints& far, const SparseMatrix& h) {
  far_ = far;
  const std::vector<int>& freed = far_.freed;
  const auto m = static_cast<Eigen::Index>(freed.size());
  if (far_.unknowns() == 0) return true;
  solve_columns();
  unit_ = points_.diagonal.cwiseAbs().maxCoeff();
  if (!(unit_ > 0.0)) return false;
  prepare_freed();
  DenseMatrix c_block = freed_.block;
  // H couples the unknowns of one point only: they stand next to each other, at most three.
  for (Eigen::Index b = 0; b < m; ++b)
    for (Eigen::Index a = std::max<Eigen::Index>(0, b - 2); a < std::min(b + 3, m); ++a)
      c_block(a, b) += h.coeff(freed[a], freed[b]) / unit_;
  freed_.factor.compute(c_block);
  if (m > 0 && freed_.factor.info() != Eigen::Success) return false;
  if (!far_.changed.empty()) prepare_changed();
  return true;
}

/// x_R of b_R - Y^T b
Vector Preconditioner::move_freed(const Vector& t) const {
  Vector x = t / unit_;
  freed_.factor.solveInPlace(x);
  return x;
}

/// The forces on Q for x = M^-1 b; takes what they do at R from t = b_R - Y^T b.
Vector Preconditioner::force_on_changed(Vector& t, const Vector& x) const {
  Vector at_q = entries(x, far_.changed);
  if (t.size() > 0) at_q.noalias() -= changed_.y_rows * move_freed(t);
  Vector pull = Vector::Zero(at_q.size());
  for (const auto& e : far_.delta) pull[e.row] += e.value * at_q[e.column];
  Vector force = changed_.factor.solve(pull);
  t.noalias() += changed_.y_rows.transpose() * force;
  return force;
}

void Preconditioner::apply(const Vector& r, Vector& out) {
  if (++served_ == served_long) factor_.op().expect_rough_solves();
  if (far_.unknowns() == 0) return factor_.op().solve_rough(r, out);
  kept_ = r;
  for (const int i : far_.freed) kept_[i] = 0.0;
  factor_.op().solve_rough(kept_, out);
  Vector t = entries(r, far_.freed);
  add_product(CblasTrans, -1.0, freed_.y, kept_, t);
  if (!far_.changed.empty()) {
    const Vector force = force_on_changed(t, out);
    add_product(CblasNoTrans, -1.0, changed_.z, force, out);
    // A held unknown moves by force / stiffness: the difference above would be rounding.
    for (const auto& e : far_.delta)
      if (e.held) out[far_.changed[e.row]] = force[e.row] / e.value;
  }
  if (far_.freed.empty()) return;
  const Vector moved = move_freed(t);
  add_product(CblasNoTrans, -1.0, freed_.y, moved, out);
  for (std::size_t j = 0; j < far_.freed.size(); ++j)
    out[far_.freed[j]] = moved[static_cast<Eigen::Index>(j)];
}

} // namespace hvi::solver
