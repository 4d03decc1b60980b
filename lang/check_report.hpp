// The hypotheses of a script as text and as JSON.
#pragma once

#include "lang/driver.hpp"
#include "solver/hypotheses/hypotheses.hpp"

#include <string>

namespace hvi::lang {

/// A table with the number, the answer and the line that decides, then both verdicts.
std::string hypotheses_text(const Script& script, const solver::HypothesisReport& report,
                            bool colour);
/// Schema hvi-check/1 (docs/schema/hvi-check-1.schema.json).
std::string hypotheses_json(const Script& script, const solver::HypothesisReport& report);

} // namespace hvi::lang
