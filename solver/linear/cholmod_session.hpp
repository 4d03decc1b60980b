// CHOLMOD behind RAII: the workspace, the matrix it reads and the factor it owns. Used by the
// ordering and by the Cholesky factorisation; nothing outside this folder sees CHOLMOD.
#pragma once

#include <cholmod.h>

namespace hvi::solver {

using Long = SuiteSparse_long;

/// The workspace and options of CHOLMOD, set up for supernodal L L^T in 64-bit integers.
class CholmodSession {
public:
  CholmodSession();
  ~CholmodSession();
  CholmodSession(const CholmodSession&) = delete;
  CholmodSession& operator=(const CholmodSession&) = delete;
  cholmod_common* common() { return &common_; }

private:
  cholmod_common common_{};
};

/// A supernodal factor and the workspace that it is computed in.
struct CholmodFactor {
  CholmodFactor() = default;
  /// The structure of the other one, without values. Throws OutOfMemory.
  CholmodFactor(const CholmodFactor& other);
  CholmodFactor& operator=(const CholmodFactor&) = delete;
  ~CholmodFactor();

  CholmodSession session;
  cholmod_factor* l = nullptr;
};

/// The arrays of a supernodal factor. The columns [super[s], super[s + 1]) of L have the rows
/// row[row_start[s]], ... up to row_start[s + 1], and their values lie by columns from
/// value_start[s] on.
struct SupernodalArrays {
  const Long *super, *row_start, *value_start, *row;
};
SupernodalArrays arrays_of(const cholmod_factor& l);

/// Throws Failure(limit) where CHOLMOD's last failure was one of size and not of memory.
void refuse_too_large(const cholmod_common& common, int unknowns);

} // namespace hvi::solver
