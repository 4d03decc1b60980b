// The load in the equation of a step.
#pragma once

#include "solver/assembly/assembly.hpp"
#include "solver/time/time_scheme.hpp"

namespace hvi::solver {

/// Adds present(0) f_n + past(0) f_{n-1} to `out`, f_n = f(t_n) or the mean over step n; f_0 =
/// f(t_0). The mean over a step is what `midpoint` averages two ends for.
void add_step_load(const LoadAssembler& loads, const TimeSpec& time, const TimeScheme& scheme,
                   int n, Vector& out);

} // namespace hvi::solver
