// See cholmod_session.hpp.
#include "solver/linear/cholmod_session.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/out_of_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::solver {
namespace {

/// Two supernodes with up to so many columns together are merged if at most this share of the
/// result is explicit zeros. The limits are larger than CHOLMOD's own 4, 16 and 48: triangular
/// solves and dense products are faster on wider blocks.
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

CholmodFactor::CholmodFactor(const CholmodFactor& other)
    : l(cholmod_l_copy_factor(other.l, session.common())) {
  // Supernodal and symbolic again: the copied values are of no use.
  const bool done = l != nullptr && (l->xtype == CHOLMOD_PATTERN ||
                                     cholmod_l_change_factor(CHOLMOD_PATTERN, 1, 1, 1, 1, l,
                                                             session.common()) != 0);
  if (done) return;
  cholmod_l_free_factor(&l, session.common());
  throw OutOfMemory("no memory for one more factor of {} unknowns", other.l->n);
}

CholmodFactor::~CholmodFactor() { cholmod_l_free_factor(&l, session.common()); }

SupernodalArrays arrays_of(const cholmod_factor& l) {
  return {static_cast<const Long*>(l.super), static_cast<const Long*>(l.pi),
          static_cast<const Long*>(l.px), static_cast<const Long*>(l.s)};
}

void refuse_too_large(const cholmod_common& common, int unknowns) {
  if (common.status == CHOLMOD_TOO_LARGE)
    throw Failure(FailureKind::limit, {},
                  fmt::format("a matrix of {} unknowns is too large to factor", unknowns));
}

} // namespace hvi::solver
