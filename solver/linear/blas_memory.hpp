// The workspace of OpenBLAS, where memory is limited.
#pragma once

namespace hvi::solver {

/// OpenBLAS asks for its workspace (128 MiB of addresses, hardly touched) at the first call and
/// tries for ever where there is none. With a limit on the addresses of this process it is asked
/// for now; false: there is no room for it. Without a limit nothing is done.
bool reserve_blas_memory();

} // namespace hvi::solver
