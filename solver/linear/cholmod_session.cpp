// See cholmod_session.hpp.
#include "solver/linear/cholmod_session.hpp"

#include "solver/common/failure.hpp"

#include <fmt/format.h>

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

} // namespace hvi::solver
