// What a run would do and cost, found out by its first steps.
#pragma once

#include "lang/script.hpp"
#include "solver/discrete/rehearsal.hpp"
#include "solver/time/run.hpp"

#include <nlohmann/json_fwd.hpp>

#include <atomic>
#include <limits>
#include <vector>

namespace hvi::lang {

/// The first steps: their counted work is that of the run, and their seconds predict those of the
/// other steps. The sums of memories grow, so the memories are run alone for more steps.
struct Forecast {
  solver::RunResult result;
  solver::MemoryForecast memory;
  double first = 0, last = 0; ///< CPU seconds after the first step, and the last one taken
  double each = std::numeric_limits<double>::infinity(); ///< of the cheapest: first ones prepare
  double most_bytes = 0; ///< the most that is held, of the steps not taken too
  int taken = 0, steps = 0;
  bool friction = false;
  /// Seconds of the memories in the steps not taken, beyond those of as many first steps.
  double history() const;
  /// Without files.
  double seconds() const;
};

/// Takes the first steps. `interrupted`: ends it, with Failure(interrupted).
Forecast forecast(const solver::Plan& plan, const solver::Discretisation& discretisation,
                  const std::atomic<bool>* interrupted = nullptr);
/// Schema hvi-plan/1. `memory`: planned_memory() of the plan.
nlohmann::ordered_json forecast_json(const Script& script, const Forecast& forecast,
                                     const std::vector<solver::HistoryReport>& memory);

} // namespace hvi::lang
