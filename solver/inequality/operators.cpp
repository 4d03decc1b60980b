// The operator of the reduced inequality: dense (LAPACK) and sparse (Eigen) (inequality.hpp).
#include "solver/inequality/inequality.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

#include <cmath>

extern "C" {
void dsymv_(const char* uplo, const int* n, const double* alpha, const double* a, const int* lda,
            const double* x, const int* incx, const double* beta, double* y, const int* incy);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrsv_(const char* uplo, const char* trans, const char* diag, const int* n, const double* a,
            const int* lda, double* x, const int* incx);
void dgetrf_(const int* m, const int* n, double* a, const int* lda, int* pivots, int* info);
void dgetrs_(const char* trans, const int* n, const int* nrhs, const double* a, const int* lda,
             const int* pivots, double* b, const int* ldb, int* info);
}

namespace hvi::solver {

namespace {

class DenseOperator final : public ReducedOperator {
public:
  DenseOperator(const DenseMatrix& s, bool symmetric)
      : s_(s), factor_(s.rows(), s.cols()), symmetric_(symmetric), pivots_(s.rows()) {}

  int size() const override { return static_cast<int>(s_.rows()); }
  bool symmetric() const override { return symmetric_; }
  Vector diagonal() const override { return s_.diagonal(); }
  double entry(int i, int j) const override { return s_(i, j); }
  int patience() const override { return 2 + size() / 100; }
  void apply(const Vector& c, Vector& out) const override {
    if (!symmetric_ || size() == 0) {
      out.noalias() = s_ * c;
      return;
    }
    out.resize(size());
    const int n = size(), one = 1;
    const double alpha = 1.0, beta = 0.0; // half of the matrix is read: memory is what it costs
    dsymv_("L", &n, &alpha, s_.data(), &n, c.data(), &one, &beta, out.data(), &one);
  }
  void apply_magnitude(const Vector& c, Vector& out) const override {
    out.setZero(size());
    double* __restrict sum = out.data();
    for (int j = 0; j < size(); ++j) {
      const double cj = std::abs(c[j]);
      const double* __restrict column = s_.data() + static_cast<std::ptrdiff_t>(j) * size();
      for (int i = 0; i < size(); ++i) sum[i] += std::abs(column[i]) * cj;
    }
  }

  bool factor(const SparseMatrix& h) override {
    factor_ = s_;
    for (int i = 0; i < h.outerSize(); ++i)
      for (SparseMatrix::InnerIterator it(h, i); it; ++it) factor_(i, it.col()) += it.value();
    const int n = size();
    int info = 0;
    if (n == 0) return true;
    if (symmetric_)
      dpotrf_("L", &n, factor_.data(), &n, &info);
    else
      dgetrf_(&n, &n, factor_.data(), &n, pivots_.data(), &info);
    return info == 0;
  }

  void solve(const Vector& b, Vector& x) const override {
    x = b;
    const int n = size(), one = 1;
    int info = 0;
    if (n == 0) return;
    if (!symmetric_) {
      dgetrs_("N", &n, &one, factor_.data(), &n, pivots_.data(), x.data(), &n, &info);
      return;
    }
    dtrsv_("L", "N", "N", &n, factor_.data(), &n, x.data(), &one);
    dtrsv_("L", "T", "N", &n, factor_.data(), &n, x.data(), &one);
  }

private:
  DenseMatrix s_, factor_;
  bool symmetric_;
  std::vector<int> pivots_;
};

class SparseOperator final : public ReducedOperator {
public:
  SparseOperator(const SparseMatrix& k, bool symmetric) : k_(k), symmetric_(symmetric) {}

  int size() const override { return static_cast<int>(k_.rows()); }
  bool symmetric() const override { return symmetric_; }
  Vector diagonal() const override { return k_.diagonal(); }
  double entry(int i, int j) const override { return k_.coeff(i, j); }
  int patience() const override { return 12; }
  void apply(const Vector& c, Vector& out) const override { out.noalias() = k_ * c; }

  void apply_magnitude(const Vector& c, Vector& out) const override {
    out.setZero(size());
    for (int i = 0; i < size(); ++i)
      for (SparseMatrix::InnerIterator it(k_, i); it; ++it)
        out[i] += std::abs(it.value() * c[it.col()]);
  }

  bool factor(const SparseMatrix& h) override {
    sum_ = k_ + h; // the pattern is the union: the same as long as h keeps its own
    const bool same = analysed_ && sum_.nonZeros() == analysed_nonzeros_;
    if (symmetric_) {
      if (!same) cholesky_.analyzePattern(sum_);
      cholesky_.factorize(sum_);
    } else {
      if (!same) lu_.analyzePattern(sum_);
      lu_.factorize(sum_);
    }
    analysed_ = true, analysed_nonzeros_ = sum_.nonZeros();
    return (symmetric_ ? cholesky_.info() : lu_.info()) == Eigen::Success;
  }

  void solve(const Vector& b, Vector& x) const override {
    if (symmetric_)
      x = cholesky_.solve(b);
    else
      x = lu_.solve(b);
  }

private:
  using ColumnMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  SparseMatrix k_;
  ColumnMatrix sum_;
  bool symmetric_, analysed_ = false;
  Eigen::Index analysed_nonzeros_ = 0;
  Eigen::SimplicialLLT<ColumnMatrix> cholesky_;
  Eigen::SparseLU<ColumnMatrix> lu_;
};

} // namespace

std::unique_ptr<ReducedOperator> dense_operator(const DenseMatrix& s, bool symmetric) {
  return std::make_unique<DenseOperator>(s, symmetric);
}

std::unique_ptr<ReducedOperator> sparse_operator(const SparseMatrix& k, bool symmetric) {
  return std::make_unique<SparseOperator>(k, symmetric);
}

} // namespace hvi::solver
