// See blas_memory.hpp.
#include "solver/linear/blas_memory.hpp"

#include <cblas.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstdlib>

namespace hvi::solver {

bool reserve_blas_memory() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return true;
  constexpr std::size_t workspace = 160 << 20;
  void* const room =
      ::mmap(nullptr, workspace, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) return false;
  ::munmap(room, workspace);
  // Large enough that no kernel for small matrices is taken, which needs no workspace.
  constexpr int n = 256;
  auto* const zeros = static_cast<double*>(std::calloc(n * n, sizeof(double)));
  if (zeros == nullptr) return false;
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n, n, 1.0, zeros, n, 0.0, zeros, n);
  std::free(zeros);
  return true;
}

} // namespace hvi::solver
