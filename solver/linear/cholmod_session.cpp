// See cholmod_session.hpp.
#include "solver/linear/cholmod_session.hpp"

#include "solver/common/failure.hpp"

#include <fmt/format.h>

#include <omp.h>

extern "C" {
void openblas_set_num_threads(int threads);
int openblas_get_num_threads(void);
}

namespace hvi::solver {

CholmodSession::CholmodSession() {
  cholmod_l_start(&common_);
  common_.print = 0;
  common_.useGPU = 0;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.final_ll = 1;
}

CholmodSession::~CholmodSession() { cholmod_l_finish(&common_); }

void refuse_too_large(const cholmod_common& common, int unknowns) {
  if (common.status == CHOLMOD_TOO_LARGE)
    throw Failure(FailureKind::limit, {},
                  fmt::format("a matrix of {} unknowns is too large to factor", unknowns));
}

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
