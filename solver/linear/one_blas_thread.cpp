// See one_blas_thread.hpp.
#include "solver/linear/one_blas_thread.hpp"

#include <omp.h>

extern "C" {
void openblas_set_num_threads(int threads);
int openblas_get_num_threads(void);
}

namespace hvi::solver {

OneBlasThread::OneBlasThread()
    : before_(openblas_get_num_threads()), levels_before_(omp_get_max_active_levels()) {
  if (before_ != 1) openblas_set_num_threads(1);
  // CHOLMOD's loops ask for four threads by name; with no active level allowed they get one.
  omp_set_max_active_levels(0);
}

OneBlasThread::~OneBlasThread() {
  if (before_ != 1) openblas_set_num_threads(before_);
  omp_set_max_active_levels(levels_before_);
}

} // namespace hvi::solver
