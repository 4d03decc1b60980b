// The sparse operator of the reduced inequality, by Eigen and UMFPACK (inequality.hpp).
#include "solver/inequality/inequality.hpp"
#include "solver/linear/own_stiffness.hpp"
#include "solver/linear/sparse_lu.hpp"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

class SparseOperator final : public ReducedOperator {
public:
  SparseOperator(const SparseMatrix& k, bool symmetric) : k_(k), symmetric_(symmetric) {}

  int size() const override { return static_cast<int>(k_.rows()); }
  bool symmetric() const override { return symmetric_; }
  Vector diagonal() const override { return k_.diagonal(); }
  Vector own_stiffness() const override { return hvi::solver::own_stiffness(k_); }
  /// Preconditioners ask for it, which symmetric matrices alone have: row j is column j.
  void column(int j, double* out) const override {
    std::fill_n(out, size(), 0.0);
    for (SparseMatrix::InnerIterator it(k_, j); it; ++it) out[it.col()] = it.value();
  }
  std::unique_ptr<ReducedOperator> unsymmetric() const override {
    return std::make_unique<SparseOperator>(k_, false);
  }
  int determinant_sign() const override { return lu_.determinant_sign(); }
  int patience() const override { return 12; }
  double bytes() const override { // the factor: at least as much as the sum
    return static_cast<double>(k_.nonZeros() + 2 * sum_.nonZeros()) *
           (sizeof(double) + sizeof(int));
  }
  void apply(const Vector& c, Vector& out) const override { out.noalias() = k_ * c; }

  void apply_magnitude(const Vector& c, Vector& out) const override {
    out.setZero(size());
    for (int i = 0; i < size(); ++i)
      for (SparseMatrix::InnerIterator it(k_, i); it; ++it)
        out[i] += std::abs(it.value() * c[it.col()]);
  }

  bool factor(const SparseMatrix& h, std::span<const int>) override {
    sum_ = k_ + h; // the pattern is the union: the same as long as h keeps its own
    if (!symmetric_) return lu_.factor(sum_);
    if (!analysed_ || sum_.nonZeros() != analysed_nonzeros_) cholesky_.analyzePattern(sum_);
    cholesky_.factorize(sum_);
    analysed_ = true, analysed_nonzeros_ = sum_.nonZeros();
    return cholesky_.info() == Eigen::Success;
  }

  void solve(const Vector& b, Vector& x) const override {
    if (symmetric_)
      x = cholesky_.solve(b);
    else
      x = lu_.solve(b);
  }

private:
  SparseMatrix k_, sum_;
  bool symmetric_, analysed_ = false;
  Eigen::Index analysed_nonzeros_ = 0;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky_;
  SparseLu lu_;
};

} // namespace

bool ReducedOperator::estimate_alone(const SparseMatrix& zero, DenseMatrix& columns) {
  if (!factor(zero, {})) return false;
  Vector x;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    estimate(columns.col(j), x);
    columns.col(j) = x;
  }
  return true;
}

void ReducedOperator::solve_rough(DenseMatrix& columns) const {
  Vector x(size());
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    solve(columns.col(j), x);
    columns.col(j) = x;
  }
}

std::unique_ptr<ReducedOperator> sparse_operator(const SparseMatrix& k, bool symmetric) {
  return std::make_unique<SparseOperator>(k, symmetric);
}

} // namespace hvi::solver
