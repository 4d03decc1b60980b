// The corrected factor (preconditioner.hpp).
#include "solver/inequality/preconditioner.hpp"

#include <cblas.h>

namespace hvi::solver {

namespace {

/// A factor that was applied this often will be applied again: the slopes change little.
constexpr int served_long = 16;

// OpenBLAS: Eigen's own products are compiled for any processor.

/// y += alpha A x, or alpha A^T x.
void add_product(CBLAS_TRANSPOSE trans, double alpha, const DenseMatrix& a, const Vector& x,
                 Vector& y) {
  const int rows = static_cast<int>(a.rows()), columns = static_cast<int>(a.cols());
  if (rows == 0 || columns == 0) return;
  cblas_dgemv(CblasColMajor, trans, rows, columns, alpha, a.data(), rows, x.data(), 1, 1.0,
              y.data(), 1);
}

} // namespace

Preconditioner::Preconditioner(const ContactPoints& points, LastFactor& factor)
    : points_(points), factor_(factor) {}

void Preconditioner::keep_up() {
  if (number_ == factor_.number()) return;
  number_ = factor_.number();
  served_ = 0;
  columns_.clear();
  freed_.forget();
}

const FarColumns& Preconditioner::columns() const {
  static const FarColumns none;
  return number_ == factor_.number() ? columns_ : none;
}

int Preconditioner::served() const { return number_ == factor_.number() ? served_ : 0; }

void Preconditioner::restore(FarColumns columns, int served) {
  keep_up();
  columns_ = std::move(columns);
  served_ = served;
  if (served_ >= served_long) factor_.op().expect_rough_solves();
}

bool Preconditioner::prepare(const FarPoints& far, const SparseMatrix& h) {
  far_ = far;
  if (far_.unknowns() == 0) return true;
  solve_far_columns(far_, factor_.op(), columns_);
  const double unit = points_.diagonal.cwiseAbs().maxCoeff();
  if (!(unit > 0.0)) return false;
  if (!freed_.prepare(far_, columns_, factor_.op(), h, unit)) return false;
  if (!far_.changed.empty()) changed_.prepare(far_, columns_, freed_);
  return true;
}

void Preconditioner::apply(const Vector& r, Vector& out) {
  if (++served_ == served_long) factor_.op().expect_rough_solves();
  if (far_.unknowns() == 0) return factor_.op().solve_rough(r, out);
  kept_ = r;
  for (const int i : far_.freed) kept_[i] = 0.0;
  factor_.op().solve_rough(kept_, out);
  Vector t(static_cast<Eigen::Index>(far_.freed.size()));
  for (Eigen::Index j = 0; j < t.size(); ++j) t[j] = r[far_.freed[j]];
  add_product(CblasTrans, -1.0, freed_.y(), kept_, t);
  Vector force;
  if (!far_.changed.empty()) {
    force = changed_.forces(far_, freed_, out, t);
    add_product(CblasNoTrans, -1.0, changed_.z(), force, out);
  }
  if (!far_.freed.empty()) {
    const Vector x = freed_.displaced(t);
    add_product(CblasNoTrans, -1.0, freed_.y(), x, out);
    for (Eigen::Index j = 0; j < x.size(); ++j) out[far_.freed[j]] = x[j];
  }
  // A held unknown moves by force / stiffness: the differences above would be rounding.
  for (const auto& e : far_.delta)
    if (e.held) out[far_.changed[e.row]] = force[e.row] / e.value;
}

} // namespace hvi::solver
