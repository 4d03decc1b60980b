// What iterative solvers have done, counted.
#pragma once

#include <algorithm>
#include <vector>

namespace hvi::solver {

/// Matrices of the multigrid. Of several unknowns the sum at each level.
struct MultigridLevel {
  double rows = 0.0, entries = 0.0;
};

struct IterationWork {
  int iterations = 0;
  int assembling = 1;           ///< processes that assemble, each on its own cells
  double bytes_of_others = 0.0; ///< the most that another process of the run has held
  /// What iterations sent to other processes, by the process that sent most.
  double messages = 0.0, bytes_sent = 0.0, reductions = 0.0;
  std::vector<MultigridLevel> levels; ///< of the largest system, the finest level first

  void add(const IterationWork& other) {
    iterations += other.iterations;
    assembling = std::max(assembling, other.assembling);
    bytes_of_others = std::max(bytes_of_others, other.bytes_of_others);
    messages += other.messages, bytes_sent += other.bytes_sent, reductions += other.reductions;
    const auto size = [](const IterationWork& of) {
      return of.levels.empty() ? 0.0 : of.levels.front().rows;
    };
    if (size(other) > size(*this)) levels = other.levels;
  }
};

} // namespace hvi::solver
