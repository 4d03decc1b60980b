// The result of a run as JSON, schema `hvi-result/1` (docs/schema/hvi-result-1.schema.json).
#pragma once

#include "solver/time/run.hpp"

#include <functional>
#include <map>
#include <string>

namespace hvi::solver {

/// What only the caller knows of a run.
struct ResultContext {
  std::map<std::string, double> params;
  std::function<int(Origin)> line_of; ///< 1-based line of an origin; 0: none
  double bandwidth = 0.0;             ///< bytes a second that this machine reads; 0: not measured
};

/// The whole result as text, numbers with 17 digits; values that are not there (NaN) are null.
std::string result_json(const RunResult& result, const Plan& plan, const ResultContext& context);

} // namespace hvi::solver
