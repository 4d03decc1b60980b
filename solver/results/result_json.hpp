// The result of a run as JSON, schema `hvi-result/1`, and what a run will do, `hvi-plan/1`
// (docs/schema).
#pragma once

#include "solver/results/run_result.hpp"

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <map>
#include <string>

namespace hvi::solver {

using UnitsByName = std::map<std::string, std::string>;

/// What only the caller knows of a run.
struct ResultContext {
  std::map<std::string, double> params;
  UnitsByName units; ///< of parameters, times and columns; often none
  std::map<std::string, UnitsByName> units_by_kind; ///< the same of "params", "columns", ...
  std::function<int(Origin)> line_of;               ///< 1-based line of an origin; 0: none
  double bandwidth = 0.0; ///< bytes a second that this machine reads; 0: not measured
};

/// The whole result; values that are not there (NaN) are null.
nlohmann::ordered_json result_json(const RunResult& result, const Problem& problem,
                                   const ResultContext& context);

/// What a run will take, predicted from its first steps.
struct PredictedWork {
  int steps = 0, first_steps = 0;
  double seconds = 0.0, bytes = 0.0; ///< CPU time; the most that is held
};

/// What a run will do: effects, matrices and memories; triangular solves, products and Newton
/// iterations are those of the first steps times steps / first_steps.
nlohmann::ordered_json plan_json(const RunResult& first_steps, const Problem& problem,
                                 const ResultContext& context, const PredictedWork& predicted);

/// As it stands in a file: numbers with 17 digits, what is no UTF-8 replaced.
std::string json_text(const nlohmann::ordered_json& value);

} // namespace hvi::solver
