// What the memories of a run will cost, found out by going through its steps with fields of one
// value: the weights, which are most of the work of kernels q(t, s), do not depend on the fields.
#pragma once

#include "solver/plan/plan.hpp"

namespace hvi::solver {

/// The cost of the steps after the first `from`, beyond that of as many first steps.
struct MemoryForecast {
  int rehearsed = 0;      ///< steps gone through; the others are extrapolated
  double seconds = 0.0;   ///< CPU time for fields of one value
  double reads = 0.0;     ///< stored fields read (HistoryReport::reads)
  double all_reads = 0.0; ///< of all steps
};

/// Runs the memories through the steps of the plan until `most_reads` fields have been read. Beyond
/// that both figures are extrapolated by the power of the number of steps that the second half of
/// these steps shows.
inline constexpr double rehearsal_reads = 1e5;
MemoryForecast rehearse_memory(const Plan& plan, int from, double most_reads = rehearsal_reads);

} // namespace hvi::solver
