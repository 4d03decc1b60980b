// How fast this machine reads memory: the limit of every triangular solve, for reports.
#pragma once

namespace hvi::solver {

/// Bytes per second that one core reads from an array of `megabytes` (default: well beyond the
/// second cache); the best of a few passes, about 5 ms in all.
double read_bandwidth(int megabytes = 16);

} // namespace hvi::solver
