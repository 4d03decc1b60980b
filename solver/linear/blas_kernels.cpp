// See blas_kernels.hpp.
#include "solver/linear/blas_kernels.hpp"

extern "C" char* openblas_get_corename(void);

namespace hvi::solver {
namespace {

/// What OpenBLAS itself asks for before it takes its kernels for AVX-512.
bool has_avx512_kernels() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

} // namespace

bool has_outgrown(std::string_view kernels, bool avx512) {
  return avx512 && (kernels == "Haswell" || kernels == "Zen");
}

BlasKernels blas_kernels() {
  const std::string name = openblas_get_corename();
  return {name, has_outgrown(name, has_avx512_kernels())};
}

} // namespace hvi::solver
