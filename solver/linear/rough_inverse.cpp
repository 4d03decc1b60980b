// See rough_inverse.hpp.
#include "solver/linear/rough_inverse.hpp"

#include "solver/linear/lapack.hpp"

#include <cblas.h>

#include <cstddef>

namespace hvi::solver {
namespace {

constexpr int smallest_block = 32;

/// L = [A 0; B C]:  L^-1 = [A^-1 0; -C^-1 B A^-1  C^-1], in place; columns lie `stride` apart.
bool invert_triangle(float* l, int n, int stride) {
  if (n <= smallest_block) {
    int info = 0;
    strti2_("L", "N", &n, l, &stride, &info);
    return info == 0;
  }
  const int half = n / 2, rest = n - half;
  float* const b = l + half;
  float* const c = b + static_cast<std::ptrdiff_t>(half) * stride;
  cblas_strsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, rest, half, -1.0F,
              c, stride, b, stride);
  if (!invert_triangle(l, half, stride)) return false;
  cblas_strmm(CblasColMajor, CblasRight, CblasLower, CblasNoTrans, CblasNonUnit, rest, half, 1.0F,
              l, stride, b, stride);
  return invert_triangle(c, rest, stride);
}

} // namespace

bool invert_from_factor(std::span<float> factor, int n) {
  if (n == 0) return true;
  for (int i = 0; i < n; ++i)
    if (factor[static_cast<std::size_t>(i) * (static_cast<std::size_t>(n) + 1)] == 0.0F)
      return false;
  if (!invert_triangle(factor.data(), n, n)) return false;
  int info = 0;
  slauum_("L", &n, factor.data(), &n, &info);
  return info == 0;
}

} // namespace hvi::solver
