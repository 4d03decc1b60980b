// The workspace of OpenBLAS, where memory is limited.
#pragma once

namespace hvi::solver {

/// OpenBLAS allocates its workspace (128 MiB of addresses, hardly touched) at the first call and
/// tries for ever where there is no memory for it. With a limit on the addresses of this process
/// the first call is made now; false: the workspace does not fit. Without a limit nothing is done.
bool reserve_blas_memory();

} // namespace hvi::solver
