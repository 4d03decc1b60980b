// Who may call METIS.
#pragma once

#include <mutex>

namespace hvi::solver {

/// METIS draws from the C library's random numbers, which the process has once: one at a time, so
/// that two runs in two threads get the same answers as one after the other.
std::mutex& metis_turn();

} // namespace hvi::solver
