// A program of several processes, where mpirun started it.
#pragma once

#include <functional>

namespace hvi::lang {

/// Runs the program in the first process, and serves it in the others. Returns its exit code.
int among_processes(const std::function<int()>& program);

} // namespace hvi::lang
