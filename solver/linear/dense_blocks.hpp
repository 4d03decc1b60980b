// Dense blocks of a factor of doubles or singles, by BLAS and LAPACK; by columns, `rows_x` from one
// column of x to the next.
#pragma once

#include "solver/linear/lapack.hpp"

#include <cblas.h>

namespace hvi::solver::dense_blocks {

/// C := A A^T, the lower triangle of n by n; A has k columns.
inline void self_product(int n, int k, const double* a, int rows_a, double* c, int rows_c) {
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n, k, 1.0, a, rows_a, 0.0, c, rows_c);
}
inline void self_product(int n, int k, const float* a, int rows_a, float* c, int rows_c) {
  cblas_ssyrk(CblasColMajor, CblasLower, CblasNoTrans, n, k, 1.0F, a, rows_a, 0.0F, c, rows_c);
}

/// C := A B^T, m by n; A and B have k columns.
inline void product(int m, int n, int k, const double* a, const double* b, int rows_ab, double* c,
                    int rows_c) {
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, m, n, k, 1.0, a, rows_ab, b, rows_ab, 0.0, c,
              rows_c);
}
inline void product(int m, int n, int k, const float* a, const float* b, int rows_ab, float* c,
                    int rows_c) {
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, m, n, k, 1.0F, a, rows_ab, b, rows_ab, 0.0F,
              c, rows_c);
}

/// L in the place of A = L L^T; the number of the first pivot that is not positive, from 1 on, or
/// 0.
inline int cholesky(int n, double* a, int rows_a) {
  int info = 0;
  dpotrf_("L", &n, a, &rows_a, &info);
  return info;
}
inline int cholesky(int n, float* a, int rows_a) {
  int info = 0;
  spotrf_("L", &n, a, &rows_a, &info);
  return info;
}

/// A := A L^-T; A is m by n and lies below L.
inline void solve_below(int m, int n, const double* l, double* a, int rows_al) {
  cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, m, n, 1.0, l,
              rows_al, a, rows_al);
}
inline void solve_below(int m, int n, const float* l, float* a, int rows_al) {
  cblas_strsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, m, n, 1.0F, l,
              rows_al, a, rows_al);
}

/// C := C - A A^T, the lower triangle of n by n, and C := C - B A^T below it, `more` rows; A and B,
/// which follows on A, have k columns.
inline void subtract_products(int n, int more, int k, const double* a, int rows_a, double* c,
                              int rows_c) {
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n, k, -1.0, a, rows_a, 1.0, c, rows_c);
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, more, n, k, -1.0, a + n, rows_a, a, rows_a,
              1.0, c + n, rows_c);
}
inline void subtract_products(int n, int more, int k, const float* a, int rows_a, float* c,
                              int rows_c) {
  cblas_ssyrk(CblasColMajor, CblasLower, CblasNoTrans, n, k, -1.0F, a, rows_a, 1.0F, c, rows_c);
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, more, n, k, -1.0F, a + n, rows_a, a, rows_a,
              1.0F, c + n, rows_c);
}

/// y := L^-1 y, or L^-T y.
inline void solve(int n, const double* l, CBLAS_TRANSPOSE transposed, double* y) {
  if (n > 0) cblas_dtrsv(CblasColMajor, CblasLower, transposed, CblasNonUnit, n, l, n, y, 1);
}

/// X := (L L^T)^-1 X, n by count.
inline void solve_both(int n, int count, const double* l, double* x) {
  for (const auto transposed : {CblasNoTrans, CblasTrans})
    if (n > 0)
      cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, transposed, CblasNonUnit, n, count, 1.0, l,
                  n, x, n);
}
inline void solve_both(int n, int count, const float* l, float* x) {
  for (const auto transposed : {CblasNoTrans, CblasTrans})
    if (n > 0)
      cblas_strsm(CblasColMajor, CblasLeft, CblasLower, transposed, CblasNonUnit, n, count, 1.0F, l,
                  n, x, n);
}

} // namespace hvi::solver::dense_blocks
