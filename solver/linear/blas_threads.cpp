// See blas_threads.hpp. OpenBLAS has one number of threads for the whole process, OpenMP one for
// each thread.
#include "solver/linear/blas_threads.hpp"

#include <omp.h>

#include <mutex>

extern "C" {
void openblas_set_num_threads(int threads);
int openblas_get_num_threads(void);
int openblas_get_parallel(void); // 0 for the serial build
}

namespace hvi::solver {
namespace {

/// Of OpenBLAS: how many want one thread, and what was set before the first of them. Else the first
/// of two runs in two threads that ends would give the other one more threads, and other bits.
struct Wanted {
  std::mutex guard;
  int by = 0, before = 1;
};

Wanted& wanted() {
  static Wanted only; // as there is one OpenBLAS
  return only;
}

} // namespace

OneBlasThread::OneBlasThread() : levels_before_(omp_get_max_active_levels()) {
  Wanted& one = wanted();
  const std::scoped_lock lock(one.guard);
  if (one.by++ == 0) {
    one.before = openblas_get_num_threads();
    if (one.before != 1) openblas_set_num_threads(1);
  }
  // Libraries may ask for threads by name; with no active level allowed they get one.
  omp_set_max_active_levels(0);
}

OneBlasThread::~OneBlasThread() {
  Wanted& one = wanted();
  const std::scoped_lock lock(one.guard);
  if (--one.by == 0 && one.before != 1) openblas_set_num_threads(one.before);
  omp_set_max_active_levels(levels_before_);
}

BlasThreads::BlasThreads(int threads) : before_(openblas_get_num_threads()) {
  if (threads != before_ && blas_is_made_for_threads()) openblas_set_num_threads(threads);
}

BlasThreads::~BlasThreads() {
  if (openblas_get_num_threads() != before_) openblas_set_num_threads(before_);
}

bool blas_is_made_for_threads() { return openblas_get_parallel() != 0; }

} // namespace hvi::solver
