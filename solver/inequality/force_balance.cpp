// The balance of forces and its errors (force_balance.hpp).
#include "solver/inequality/force_balance.hpp"

#include "solver/inequality/iterative_operator.hpp"
#include "solver/inequality/shared_scales.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

KeptProduct::KeptProduct(const ReducedOperator& s)
    : op_(s), s_c_(Vector::Zero(s.size())), c_(s_c_), magnitude_(s_c_) {}

void KeptProduct::update(const Vector& c) {
  if (c == c_) return;
  op_.apply(c, s_c_);
  belongs_to(c);
}

void KeptProduct::take(const Vector& c, const Vector& s_c) {
  s_c_ = s_c;
  belongs_to(c);
}

void KeptProduct::belongs_to(const Vector& c) {
  c_ = c;
  have_magnitude_ = false;
}

void KeptProduct::forget() {
  c_.setConstant(std::numeric_limits<double>::quiet_NaN());
  have_magnitude_ = false;
}

double KeptProduct::correct(const Vector& c) {
  op_.apply(c, exact_);
  s_c_.swap(exact_);
  return (s_c_ - exact_).lpNorm<Eigen::Infinity>();
}

const Vector& KeptProduct::magnitude(const Vector& c) {
  if (!have_magnitude_) op_.apply_magnitude(c, magnitude_);
  have_magnitude_ = true;
  return magnitude_;
}

namespace {

/// The largest of the rows, each divided by its unit.
double largest_row(const Vector& rows, const ContactPoints& points) {
  double out = 0.0;
  for (Eigen::Index i = 0; i < rows.size(); ++i)
    out = std::max(out, std::abs(rows[i]) / points.row_units[i]);
  return out;
}

/// Each row against its own size. A row where nothing acts (0 = 0) holds rounding of the others: no
/// error of its own.
double worst_ratio(const Errors& of, const ContactPoints& points) {
  const double rounding = 0x1p-53 * largest_row(of.size, points);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < of.left.size(); ++i) {
    const double error = std::abs(of.left[i]);
    if (error <= rounding * points.row_units[i] || error <= worst * of.size[i]) continue;
    worst = error / of.size[i];
    if (std::isnan(worst)) return std::numeric_limits<double>::infinity();
  }
  return worst;
}

/// The rows of A x, and of |A||x|.
template <class Row>
void for_rows(const SparseMatrix& a, const Vector& x, const Row& row) {
  const int* start = a.outerIndexPtr();
  const int* column = a.innerIndexPtr();
  const double* value = a.valuePtr();
  for (int i = 0; i < a.rows(); ++i) {
    double sum = 0.0, size = 0.0;
    for (int e = start[i]; e < start[i + 1]; ++e) {
      const double term = value[e] * x[column[e]];
      sum += term;
      size += std::abs(term);
    }
    row(i, sum, size);
  }
}

Pieces pieces_of(const ReducedOperator& s) {
  if (const auto* all_rows = s.iterative()) return all_rows->matrix().pieces();
  return Pieces(s.size(), [&](int j, Vector& entries) { s.column(j, entries.data()); });
}

} // namespace

double largest_left(const Errors& of, const ContactPoints& points) {
  return largest_row(of.left, points);
}

/// What each row is made of, from below.
Vector ForceBalance::sizes(const Vector& c) const {
  Vector out = load_.cwiseAbs();
  if (sums_cancel()) {
    Vector magnitude;
    product.op().apply_magnitude(c, magnitude);
    return out + magnitude;
  }
  const Vector own = points_.diagonal.cwiseProduct(c);
  return out + own.cwiseAbs() + (product.value() - own).cwiseAbs();
}

double ForceBalance::worst_of(const Vector& residual, const Vector& c, const Vector& xi) const {
  return worst_ratio({residual, sizes(c), 0.0}, c, xi);
}

Vector ForceBalance::beyond(double ratio, double seen, const Vector& residual, const Vector& c,
                            const Vector& xi) const {
  const Vector size = sizes(c);
  const double largest = largest_multiplier(xi);
  const auto whole_size = all_rows_->matrix().whole_sizes(c);
  const auto holds = [&](Eigen::Index i) {
    const double error = std::abs(residual[i]);
    return error <= ratio * size[i] ||
           error <= ratio * (size[i] + turned_size(i, whole_size, largest));
  };
  for (Eigen::Index i = 0; i < residual.size(); ++i)
    if (std::abs(residual[i]) > seen && !holds(i)) return {};
  Vector out = Vector::Zero(residual.size());
  bool any = false;
  for (Eigen::Index i = 0; i < residual.size(); ++i)
    if (std::abs(residual[i]) <= seen && !holds(i)) out[i] = residual[i], any = true;
  return any ? out : Vector();
}

/// The row of a pressure has no diagonal, and its sum is what is left.
bool ForceBalance::sums_cancel() const { return !points_.problem.of_unknown.empty(); }

ForceBalance::ForceBalance(const ContactPoints& points, const ReducedOperator& s, double target)
    : product(s), points_(points), all_rows_(s.iterative()), target_(target) {}

double ForceBalance::worst_ratio(const Errors& of, const Vector& c, const Vector& xi) const {
  return all_rows_ != nullptr ? worst_of_all_rows(of, c, xi) : solver::worst_ratio(of, points_);
}

/// A part of what row i has in axes that are turned, as the certificate of a step has it
/// (solver/discrete/certificate.cpp).
double ForceBalance::turned_size(Eigen::Index i, const std::function<double(int)>& whole_size,
                                 double largest_xi) const {
  double weight = 0.0;
  for (SparseMatrix::InnerIterator it(points_.force_of, i); it; ++it)
    weight += std::abs(it.value());
  return part_of_turned_row * (whole_size(static_cast<int>(i)) + weight * largest_xi);
}

/// Of several unknowns each has multipliers of its own, which are in the rows' sizes.
double ForceBalance::largest_multiplier(const Vector& xi) const {
  return all_rows_->several_unknowns() || xi.size() == 0 ? 0.0 : xi.lpNorm<Eigen::Infinity>();
}

/// Each row against its own size.
double ForceBalance::worst_of_all_rows(const Errors& of, const Vector& c, const Vector& xi) const {
  const double largest_xi = largest_multiplier(xi);
  const auto whole_size = all_rows_->matrix().whole_sizes(c);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < of.left.size(); ++i) {
    const double error = std::abs(of.left[i]);
    if (error <= worst * of.size[i]) continue;
    const double size = of.size[i] + turned_size(i, whole_size, largest_xi);
    if (error <= worst * size) continue;
    worst = error / size;
    if (std::isnan(worst)) return std::numeric_limits<double>::infinity();
  }
  return worst;
}

const Vector& ForceBalance::residual(const Vector& xi) {
  force_.noalias() = points_.force_of * xi;
  errors_.left = load_ - product.value() - force_;
  return errors_.left;
}

void ForceBalance::leave_at_rest(const Vector& xi, Vector& c) {
  force_.noalias() = points_.force_of * xi;
  force_ = load_ - force_;
  bool rounding = false;
  for (Eigen::Index i = 0; i < c.size() && !rounding; ++i)
    rounding = force_[i] == 0.0 && c[i] != 0.0;
  if (!rounding) return;
  if (!pieces_) pieces_ = std::make_unique<const Pieces>(pieces_of(product.op()));
  pieces_->leave_at_rest(force_, c);
}

/// First against |r| + |S_ii c_i| + |(S c)_i - S_ii c_i| + |G^T W x|, which bounds the ratio from
/// above; |S||c| only where that could decide, as it gains two digits at the most: it costs another
/// pass over S.
const Errors& ForceBalance::errors(const Vector& c, const Vector& xi) {
  Errors& out = errors_;
  const Vector &s_c = product.value(), &diagonal = points_.diagonal;
  out.left.resize(c.size()), out.size.resize(c.size());
  for_rows(points_.force_of, xi, [&](int i, double force, double force_size) {
    out.left[i] = load_[i] - s_c[i] - force;
    const double own = diagonal[i] * c[i];
    out.size[i] = std::abs(load_[i]) + std::abs(own) + std::abs(s_c[i] - own) + force_size;
  });
  out.worst = worst_ratio(out, c, xi);
  const bool far = out.worst > 1e2 * target_ && !sums_cancel();
  if (!(out.worst > target_) || far) return out;
  const Vector& magnitude = product.magnitude(c);
  for_rows(points_.force_of, xi, [&](int i, double, double force_size) {
    out.size[i] = std::abs(load_[i]) + magnitude[i] + force_size;
  });
  out.worst = worst_ratio(out, c, xi);
  return out;
}

} // namespace hvi::solver
