// The hypotheses of a script as text and as JSON.
#pragma once

#include "lang/script.hpp"
#include "solver/hypotheses/hypotheses.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace hvi::lang {

/// A table with the number, the answer and the line that decides, then both verdicts.
std::string hypotheses_text(const Script& script, const solver::HypothesisReport& report,
                            bool colour);
/// Schema hvi-check/1 (docs/schema/hvi-check-1.schema.json).
nlohmann::ordered_json hypotheses_json(const Script& script,
                                       const solver::HypothesisReport& report);

} // namespace hvi::lang
