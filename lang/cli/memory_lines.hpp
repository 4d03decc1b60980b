// What the terminal shows of the memory: one line for each kernel.
#pragma once

#include "solver/history/history.hpp"
#include "solver/plan/problem.hpp"

namespace hvi::lang {

/// Route, stored fields, verified error with the bound that follows from it, audit, reason. Fields
/// of a report that a run has not filled in yet are left out.
void print_memory(const solver::Problem& problem,
                  const std::vector<solver::HistoryReport>& reports);

} // namespace hvi::lang
