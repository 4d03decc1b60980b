// What a run costs, by the clock and counted.
#pragma once

#include "solver/linear/iteration_work.hpp"

#include <cstdint>

namespace hvi::solver {

/// Seconds of CPU time by phase; history, triangular solves and inequality, parts of
/// steps, by the wall clock.
struct Timing {
  double mesh = 0, assembly = 0, ordering = 0, factor = 0, history = 0, triangular_solves = 0,
         inequality = 0, steps = 0, output = 0, total = 0;
  double factor_bytes_read = 0; ///< by all triangular solves
};

/// Work done, counted: what the tests of "only the effects a scene calls for" compare.
struct WorkCounters {
  int matrices = 0, analyses = 0, factorisations = 0, triangular_solves = 0, products = 0,
      newton = 0, history_fields = 0, fallback_steps = 0;
  /// Steps whose branch was followed from the last state, the inner steps that took, and steps
  /// where that could not be done.
  int followed_steps = 0, inner_steps = 0, unfollowed_steps = 0;
  std::int64_t field_reads = 0; ///< of stored history fields
  double bytes = 0;
  bool singles = false; ///< a factor is in single precision
  IterationWork iterative;
};

} // namespace hvi::solver
