// The inverse of a symmetric matrix from its Cholesky factor, in single precision.
#pragma once

#include <span>

namespace hvi::solver {

/// On entry the lower triangle holds the factor L (n x n, by columns), on return that of
/// (L L^T)^-1. False when L has a zero on its diagonal.
///
/// What LAPACK's spotri does, without the triangular solve from the right in its strtri: OpenBLAS
/// 0.3.21 ends there with a misaligned read on processors older than AVX (its kernels Prescott,
/// Core2 and Barcelona; strsm_kernel_RT; OpenBLAS issue 5810 shows the same place).
bool invert_from_factor(std::span<float> factor, int n);

} // namespace hvi::solver
