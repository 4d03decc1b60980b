// See dense.hpp.
#include "solver/linear/dense.hpp"

#include "solver/common/numbers.hpp"
#include "solver/linear/lapack.hpp"

#include <cblas.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

int to_int(Eigen::Index size) { return static_cast<int>(size); }

/// LAPACK takes no leading dimension below 1.
int stride(const DenseMatrix& a) { return std::max(1, to_int(a.rows())); }

Vector no_answer(Eigen::Index size) { return Vector::Constant(size, not_a_number); }
DenseMatrix no_answer(Eigen::Index rows, Eigen::Index columns) {
  return DenseMatrix::Constant(rows, columns, not_a_number);
}

/// Of `call(work, size of it, info)`: how much it asks for where the size is -1.
template <class Call>
Vector workspace(const Call& call) {
  double wanted = 1.0;
  int info = 0;
  call(&wanted, -1, info);
  return Vector(std::max<Eigen::Index>(1, static_cast<Eigen::Index>(wanted)));
}

/// The same, and then the call itself. False where it failed.
template <class Call>
bool with_workspace(const Call& call) {
  Vector work = workspace(call);
  int info = 0;
  call(work.data(), to_int(work.size()), info);
  return info == 0;
}

/// Ascending. The matrix becomes the eigenvectors where they are wanted. False: no answer.
bool find_spectrum(DenseMatrix& a, Vector& values, bool wants_vectors) {
  const int n = to_int(a.rows()), lda = stride(a);
  values.resize(n);
  if (n == 0) return true;
  if (!a.allFinite()) return false;
  const char* const job = wants_vectors ? "V" : "N";
  std::vector<int> integers(static_cast<std::size_t>(wants_vectors ? 3 + 5 * n : 1));
  const int count = to_int(static_cast<Eigen::Index>(integers.size()));
  return with_workspace([&](double* work, int size, int& info) {
    dsyevd_(job, "L", &n, a.data(), &lda, values.data(), work, &size, integers.data(), &count,
            &info, 1, 1);
  });
}

} // namespace

Vector symmetric_eigenvalues(const DenseMatrix& a) {
  DenseMatrix used = a;
  Vector values;
  return find_spectrum(used, values, false) ? values : no_answer(a.rows());
}

Spectrum symmetric_spectrum(const DenseMatrix& a) {
  Spectrum out{{}, a};
  if (!find_spectrum(out.vectors, out.values, true))
    out = {no_answer(a.rows()), no_answer(a.rows(), a.cols())};
  return out;
}

Vector generalised_eigenvalues(const DenseMatrix& a, const DenseMatrix& g) {
  const int n = to_int(a.rows()), lda = stride(a), type = 1, one = 1;
  Vector values(n);
  if (n == 0) return values;
  if (!a.allFinite() || !g.allFinite()) return no_answer(n);
  DenseMatrix used = a, metric = g;
  int integer = 0;
  const bool found = with_workspace([&](double* work, int size, int& info) {
    dsygvd_(&type, "N", "L", &n, used.data(), &lda, metric.data(), &lda, values.data(), work, &size,
            &integer, &one, &info, 1, 1);
  });
  return found ? values : no_answer(n);
}

Eigen::VectorXcd eigenvalues(const DenseMatrix& a) {
  const int n = to_int(a.rows()), lda = stride(a), one = 1;
  Vector real(n), imaginary(n);
  if (n > 0) {
    DenseMatrix used = a;
    double none = 0.0;
    const bool found = a.allFinite() && with_workspace([&](double* work, int size, int& info) {
                         dgeev_("N", "N", &n, used.data(), &lda, real.data(), imaginary.data(),
                                &none, &one, &none, &one, work, &size, &info, 1, 1);
                       });
    if (!found) real = imaginary = no_answer(n);
  }
  Eigen::VectorXcd out(n);
  for (int i = 0; i < n; ++i) out[i] = {real[i], imaginary[i]};
  return out;
}

LeftSingular left_singular(const DenseMatrix& a) {
  const int m = to_int(a.rows()), n = to_int(a.cols()), least = std::min(m, n), one = 1,
            lda = stride(a);
  LeftSingular out{Vector(least), DenseMatrix(m, least)};
  if (least == 0) return out;
  DenseMatrix used = a;
  double none = 0.0;
  const bool found = a.allFinite() && with_workspace([&](double* work, int size, int& info) {
                       dgesvd_("S", "N", &m, &n, used.data(), &lda, out.values.data(),
                               out.vectors.data(), &lda, &none, &one, work, &size, &info, 1, 1);
                     });
  if (!found) out = {no_answer(least), no_answer(m, least)};
  return out;
}

DenseCholesky::DenseCholesky(const DenseMatrix& g) : lower_(g) {
  const int n = to_int(g.rows()), lda = stride(g);
  int info = 0;
  if (n > 0) dpotrf_("L", &n, lower_.data(), &lda, &info);
  positive_ = info == 0 && lower_.diagonal().allFinite();
}

bool is_positive_definite(const DenseMatrix& a, double rounding) {
  const Vector root = a.diagonal().cwiseAbs().cwiseSqrt();
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i)
      if (!(std::abs(a(i, j) - a(j, i)) <= rounding * root[i] * root[j])) return false;
  return DenseCholesky(a).positive();
}

DenseMatrix DenseCholesky::lower() const {
  return positive_ ? DenseMatrix(lower_.triangularView<Eigen::Lower>())
                   : no_answer(lower_.rows(), lower_.cols());
}

DenseMatrix DenseCholesky::solve_lower(const DenseMatrix& b) const {
  if (!positive_) return no_answer(b.rows(), b.cols());
  DenseMatrix x = b;
  if (x.size() > 0)
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, to_int(x.rows()),
                to_int(x.cols()), 1.0, lower_.data(), stride(lower_), x.data(), stride(x));
  return x;
}

DenseMatrix DenseCholesky::solve(const DenseMatrix& b) const {
  DenseMatrix x = solve_lower(b);
  if (positive_ && x.size() > 0)
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, to_int(x.rows()),
                to_int(x.cols()), 1.0, lower_.data(), stride(lower_), x.data(), stride(x));
  return x;
}

Vector DenseCholesky::solve(const Vector& b) const {
  if (!positive_) return no_answer(b.size());
  Vector x = b;
  for (const auto transposed : {CblasNoTrans, CblasTrans})
    if (x.size() > 0)
      cblas_dtrsv(CblasColMajor, CblasLower, transposed, CblasNonUnit, to_int(x.size()),
                  lower_.data(), stride(lower_), x.data(), 1);
  return x;
}

DenseLu::DenseLu(const DenseMatrix& a) : factor_(a), rows_(static_cast<std::size_t>(a.rows())) {
  if (a.size() == 0) return;
  norm_ = a.cwiseAbs().colwise().sum().maxCoeff();
  if (!std::isfinite(norm_)) factor_.setConstant(not_a_number);
  const int n = to_int(a.rows());
  int info = 0; // above 0: a pivot is 0, and what is divided by it is not finite
  dgetrf_(&n, &n, factor_.data(), &n, rows_.data(), &info);
}

void DenseLu::solve_in_place(double* b, Eigen::Index columns, char transposed) const {
  const int n = to_int(factor_.rows()), count = to_int(columns);
  if (n == 0 || count == 0) return;
  int info = 0;
  dgetrs_(&transposed, &n, &count, factor_.data(), &n, rows_.data(), b, &n, &info);
}

Vector DenseLu::solve(const Vector& b, bool transposed) const {
  Vector x = b;
  solve_in_place(x.data(), 1, transposed ? 'T' : 'N');
  return x;
}

DenseMatrix DenseLu::solve(const DenseMatrix& b) const {
  DenseMatrix x = b;
  solve_in_place(x.data(), x.cols(), 'N');
  return x;
}

double DenseLu::inverse_condition() const {
  const int n = to_int(factor_.rows());
  if (n == 0) return 1.0;
  if (!factor_.allFinite()) return not_a_number;
  double out = 0.0;
  Vector work(4 * n);
  std::vector<int> integers(static_cast<std::size_t>(n));
  int info = 0;
  dgecon_("1", &n, factor_.data(), &n, &norm_, &out, work.data(), integers.data(), &info, 1);
  return out;
}

DenseMatrix solve_positive(const DenseMatrix& g, const DenseMatrix& b) {
  return DenseCholesky(g).solve(b);
}

DenseMatrix solve_square(const DenseMatrix& a, const DenseMatrix& b) { return DenseLu(a).solve(b); }

DenseMatrix least_squares(const DenseMatrix& a, const DenseMatrix& b, double dependent) {
  const int m = to_int(a.rows()), n = to_int(a.cols()), count = to_int(b.cols()), lda = stride(a);
  if (!a.allFinite() || !b.allFinite()) return no_answer(n, count);
  DenseMatrix used = a, x = DenseMatrix::Zero(std::max(m, n), count);
  x.topRows(m) = b;
  const int ldb = stride(x);
  std::vector<int> pivots(static_cast<std::size_t>(n), 0);
  int rank = 0;
  const bool found = with_workspace([&](double* work, int size, int& info) {
    dgelsy_(&m, &n, &count, used.data(), &lda, x.data(), &ldb, pivots.data(), &dependent, &rank,
            work, &size, &info);
  });
  return found ? DenseMatrix(x.topRows(n)) : no_answer(n, count);
}

DenseMatrix least_squares(const DenseMatrix& a, const DenseMatrix& b) {
  constexpr double rounding = std::numeric_limits<double>::epsilon();
  return least_squares(a, b, rounding * static_cast<double>(std::max(a.rows(), a.cols())));
}

QrSolution solve_by_qr(const DenseMatrix& a, const Vector& b) {
  const int m = to_int(a.rows()), n = to_int(a.cols()), one = 1, lda = stride(a);
  QrSolution out{Vector(n), DenseMatrix::Zero(n, n)};
  if (n == 0) return out;
  DenseMatrix factor = a;
  Vector reflections(n), x = b;
  const bool found = with_workspace([&](double* work, int size, int& info) {
                       dgeqrf_(&m, &n, factor.data(), &lda, reflections.data(), work, &size, &info);
                     }) &&
                     with_workspace([&](double* work, int size, int& info) {
                       dormqr_("L", "T", &m, &one, &n, factor.data(), &lda, reflections.data(),
                               x.data(), &lda, work, &size, &info, 1, 1);
                     });
  if (!found) return {no_answer(n), no_answer(n, n)};
  cblas_dtrsv(CblasColMajor, CblasUpper, CblasNoTrans, CblasNonUnit, n, factor.data(), lda,
              x.data(), 1);
  out.x = x.head(n);
  out.r.triangularView<Eigen::Upper>() = factor.topRows(n);
  return out;
}

} // namespace hvi::solver
