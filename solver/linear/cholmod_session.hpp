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

/// Throws Failure(limit) where CHOLMOD's last failure was one of size and not of memory.
void refuse_too_large(const cholmod_common& common, int unknowns);

} // namespace hvi::solver
