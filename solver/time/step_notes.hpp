// What a run says of its steps: the worst numbers, events, choices, and why one is no result.
// Called by the loop in run.cpp.
#pragma once

#include "solver/plan/plan.hpp"
#include "solver/results/run_result.hpp"
#include "solver/step/run_state.hpp"

namespace hvi::solver {

/// Laws beyond the theorem: that jump down (the run says which solution it follows), or are
/// coupled.
void note_choices(const Plan& plan, const Contact& contact, RunResult& result);
/// Worst numbers over the steps, releases, ends of branches and snaps of step n.
void note_step(const StepResult& step, int n, double t, const TimeGrid& grid, const Plan& plan,
               RunResult& result);
/// Bounds of coupled laws that are below 0 in step n: of each law the first time.
void note_negative_bounds(const RunState& run, int n, const Plan& plan, RunResult& result);
/// With `least_energy`: in how many steps that is proved. Each of the others has its note.
void note_proofs(const Plan& plan, RunResult& result);
/// Why no factor is in single precision where that was asked for.
void note_precision(const Plan& plan, const RunState& run, RunResult& result);
/// Throws Failure(not_certified) with the law to blame.
[[noreturn]] void refuse_step(const StepResult& step, int n, const RunState& run, const Plan& plan);

} // namespace hvi::solver
