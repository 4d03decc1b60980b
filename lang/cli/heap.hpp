// How the memory of the program grows. hvi-run only: a library leaves that to its program.
#pragma once

namespace hvi::lang {

/// Many matrices and vectors are allocated and freed while a problem is set up: their memory is
/// kept for the next ones, and lies in large pages where the system has them. Large blocks are
/// still returned to the system at once. To be called first in `main`.
void prepare_heap();

} // namespace hvi::lang
