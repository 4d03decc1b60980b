// What the terminal shows of a run and of a plan: a line for each kernel, and how the linear
// systems are solved.
#pragma once

#include "solver/history/history.hpp"
#include "solver/plan/problem.hpp"
#include "solver/time/run.hpp"

namespace hvi::lang {

/// Route, stored fields, verified error with the bound that follows from it, audit, reason. Fields
/// of a report that a run has not filled in yet are left out.
void print_memory(const solver::Problem& problem,
                  const std::vector<solver::HistoryReport>& reports);

/// Which solver the run chose and why; nothing where it was asked for.
void print_solver(const solver::ChosenSolver& chosen);
/// A line for those who wait for large factors; empty where OpenBLAS knows the processor.
std::string advice_on_kernels();

} // namespace hvi::lang
