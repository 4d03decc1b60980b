// See cholmod_session.hpp.
#include "solver/linear/cholmod_session.hpp"

#include "solver/common/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::solver {
namespace {

/// Two supernodes with up to so many columns together are merged if at most this share of the
/// result is explicit zeros. The limits are larger than CHOLMOD's own 4, 16 and 48, because each
/// pair of supernodes costs a start of OpenMP's threads and two readings of the clock.
constexpr std::array<std::size_t, 3> merged_columns{8, 24, 64};
constexpr std::array<double, 3> merged_zeros{0.8, 0.1, 0.05};

} // namespace

CholmodSession::CholmodSession() {
  cholmod_l_start(&common_);
  common_.print = 0;
  common_.useGPU = 0;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.final_ll = 1;
  std::ranges::copy(merged_columns, common_.nrelax);
  std::ranges::copy(merged_zeros, common_.zrelax);
}

CholmodSession::~CholmodSession() { cholmod_l_finish(&common_); }

void refuse_too_large(const cholmod_common& common, int unknowns) {
  if (common.status == CHOLMOD_TOO_LARGE)
    throw Failure(FailureKind::limit, {},
                  fmt::format("a matrix of {} unknowns is too large to factor", unknowns));
}

} // namespace hvi::solver
