// Freed and changed unknowns (far_unknowns.hpp).
#include "solver/inequality/far_unknowns.hpp"

#include <cblas.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// A stiffness is far from the factored one where it changed by more than this times the body's own
/// stiffness at the point.
constexpr double far_away = 2.0;

/// A^T B, by OpenBLAS: Eigen's own products are compiled for any processor.
DenseMatrix inner(const DenseMatrix& a, const DenseMatrix& b) {
  const int rows = static_cast<int>(a.rows()), m = static_cast<int>(a.cols()),
            k = static_cast<int>(b.cols());
  DenseMatrix out(m, k);
  if (m > 0 && k > 0)
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, m, k, rows, 1.0, a.data(), rows, b.data(),
                rows, 0.0, out.data(), m);
  return out;
}

bool holds_some(const PointMatrices& d, const PointData& q) {
  return std::ranges::any_of(q.block(d),
                             [&](double v) { return std::abs(v) * q.local > holding_stiffness; });
}

bool is_close(const PointData& q, const PointMatrices& d, const PointMatrices& d_factored) {
  const auto now = q.block(d), then = q.block(d_factored);
  for (std::size_t k = 0; k < now.size(); ++k)
    if (!(std::abs(now[k] - then[k]) * q.local <= far_away)) return false;
  return true;
}

/// Adds the unknowns of a far point, which no other point uses, to the freed or the changed ones.
/// False: the factor holds it along one direction.
bool add_far(const ContactPoints& points, int p, const PointMatrices& d,
             const PointMatrices& d_factored, FarPoints& out) {
  const PointData& q = points[p];
  const bool held = holds_all(d_factored, q);
  if (!held && holds_some(d_factored, q)) return false;
  out.most_rows = std::max(out.most_rows, q.rows);
  int unknown[slot::most_arguments] = {};
  double g[slot::most_arguments] = {};
  for (int a = 0; a < q.rows; ++a)
    for (SparseMatrix::InnerIterator it(points.g, q.first + a); it; ++it)
      if (it.value() != 0.0) unknown[a] = static_cast<int>(it.col()), g[a] = it.value();
  const bool now_held = holds_all(d, q);
  const auto now = q.block(d), then = q.block(d_factored);
  for (int a = 0; a < q.rows; ++a) {
    if (held) {
      out.freed.push_back(unknown[a]);
      continue;
    }
    for (int b = 0; b < q.rows; ++b) {
      const double change = now[q.rows * a + b] - then[q.rows * a + b];
      const auto row = static_cast<int>(out.changed.size());
      out.delta.push_back({row, row - a + b, q.weight * g[a] * g[b] * change, now_held && a == b});
    }
    out.changed.push_back(unknown[a]);
  }
  return true;
}

} // namespace

bool find_far_points(const ContactPoints& points, const PointMatrices& d,
                     const PointMatrices& d_factored, std::size_t most, FarPoints& out) {
  out.freed.clear(), out.changed.clear(), out.delta.clear();
  out.most_rows = 1;
  out.is_far.resize(points.data.size());
  for (int p = 0; p < points.size(); ++p) {
    const bool close = is_close(points[p], d, d_factored);
    out.is_far[p] = !close;
    if (close) continue;
    if (!points[p].exclusive || !add_far(points, p, d, d_factored, out)) return false;
    if (out.unknowns() > most) return false;
  }
  return true;
}

void solve_far_columns(const FarPoints& far, const ReducedOperator& s, FarColumns& columns) {
  std::vector<int> missing;
  for (const int i : far.freed)
    if (!columns.contains(i)) missing.push_back(i);
  const auto first_changed = static_cast<int>(missing.size());
  for (const int i : far.changed)
    if (!columns.contains(i)) missing.push_back(i);
  if (missing.empty()) return;
  DenseMatrix found = DenseMatrix::Zero(s.size(), static_cast<Eigen::Index>(missing.size()));
  for (int j = 0; j < static_cast<int>(missing.size()); ++j) {
    if (j >= first_changed)
      found(missing[j], j) = 1.0;
    else
      s.column(missing[j], &found(0, j));
  }
  s.solve_rough(found);
  for (std::size_t j = 0; j < missing.size(); ++j)
    columns[missing[j]] = found.col(static_cast<Eigen::Index>(j));
}

void FreedUnknowns::forget() {
  unknowns_.clear();
  y_.resize(0, 0);
  block_.resize(0, 0);
}

void FreedUnknowns::make_block(const FarColumns& columns, const ReducedOperator& s) {
  const auto m = static_cast<Eigen::Index>(unknowns_.size());
  y_.resize(s.size(), m);
  DenseMatrix rows(s.size(), m);
  for (Eigen::Index j = 0; j < m; ++j) {
    y_.col(j) = columns.at(unknowns_[j]);
    for (const int i : unknowns_) y_(i, j) = 0.0;
    s.column(unknowns_[j], &rows(0, j));
  }
  rows /= unit_;
  block_ = -inner(rows, y_);
  for (Eigen::Index b = 0; b < m; ++b)
    for (Eigen::Index a = 0; a < m; ++a) block_(a, b) += rows(unknowns_[a], b);
}

/// Y and S_RR - S_RF Y are as they are while R and the factor stay.
bool FreedUnknowns::prepare(const FarPoints& far, const FarColumns& columns,
                            const ReducedOperator& s, const SparseMatrix& h, double unit) {
  const std::vector<int>& freed = far.freed;
  unit_ = unit;
  if (freed != unknowns_ || y_.rows() != s.size()) {
    unknowns_ = freed;
    make_block(columns, s);
  }
  const auto m = static_cast<Eigen::Index>(freed.size());
  DenseMatrix c = block_;
  // H couples the unknowns of one point only: they stand next to each other.
  const Eigen::Index rows = far.most_rows;
  for (Eigen::Index b = 0; b < m; ++b)
    for (Eigen::Index a = std::max<Eigen::Index>(0, b - rows + 1); a < std::min(b + rows, m); ++a)
      c(a, b) += h.coeff(freed[a], freed[b]) / unit_;
  factor_ = DenseCholesky(c);
  return factor_.positive();
}

Vector FreedUnknowns::displaced(const Vector& t) const { return factor_.solve(Vector(t / unit_)); }

DenseMatrix FreedUnknowns::compliance(const DenseMatrix& y_rows) const {
  return y_rows * factor_.solve(DenseMatrix(y_rows.transpose())) / unit_;
}

void ChangedUnknowns::prepare(const FarPoints& far, const FarColumns& columns,
                              const FreedUnknowns& freed) {
  const std::vector<int>& changed = far.changed;
  const auto k = static_cast<Eigen::Index>(changed.size());
  z_.resize(freed.y().rows(), k);
  for (Eigen::Index j = 0; j < k; ++j) z_.col(j) = columns.at(changed[j]);
  y_rows_.resize(k, freed.y().cols());
  DenseMatrix g(k, k);
  for (Eigen::Index a = 0; a < k; ++a) y_rows_.row(a) = freed.y().row(changed[a]);
  for (Eigen::Index a = 0; a < k; ++a) g.row(a) = z_.row(changed[a]);
  if (!far.freed.empty()) g += freed.compliance(y_rows_);
  DenseMatrix w = DenseMatrix::Identity(k, k);
  for (const auto& e : far.delta) w.row(e.row) += e.value * g.row(e.column);
  factor_ = DenseLu(w);
}

Vector ChangedUnknowns::forces(const FarPoints& far, const FreedUnknowns& freed, const Vector& x,
                               Vector& t) const {
  Vector at_q(static_cast<Eigen::Index>(far.changed.size()));
  for (Eigen::Index j = 0; j < at_q.size(); ++j) at_q[j] = x[far.changed[j]];
  if (t.size() > 0) at_q.noalias() -= y_rows_ * freed.displaced(t);
  Vector pull = Vector::Zero(at_q.size());
  for (const auto& e : far.delta) pull[e.row] += e.value * at_q[e.column];
  Vector force = factor_.solve(pull);
  t.noalias() += y_rows_.transpose() * force;
  return force;
}

} // namespace hvi::solver
