// See blas_memory.hpp.
#include "solver/linear/blas_memory.hpp"

#include <cblas.h>
#include <sys/resource.h>

#include <cstdlib>

namespace hvi::solver {

bool reserve_blas_memory() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return true;
  constexpr std::size_t workspace = 160 << 20;
  void* volatile room = std::malloc(workspace); // volatile: or the compiler leaves it out
  if (room == nullptr) return false;
  std::free(room);
  // Large enough that no kernel for small matrices is taken, which needs no workspace.
  constexpr int n = 256;
  auto* const zeros = static_cast<double*>(std::calloc(n * n, sizeof(double)));
  if (zeros == nullptr) return false;
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n, n, 1.0, zeros, n, 0.0, zeros, n);
  std::free(zeros);
  return true;
}

} // namespace hvi::solver
