// `--accuracy X --of NAME` and `using accuracy = X`: what is asked for, and the evidence as text
// and JSON. Between the run command and solver/study/accuracy.hpp.
#pragma once

#include "lang/cli/options.hpp"
#include "solver/study/accuracy.hpp"

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <string>

namespace hvi::lang {

/// Lines of progress on stderr, unless --quiet.
std::function<void(const std::string&)> accuracy_teller(const Options& options);
/// The runs that were made, the settings chosen, and the verdict.
std::string accuracy_text(const solver::AccuracyResult& result);
/// The member `accuracy` of a result (schema hvi-result/1).
nlohmann::ordered_json accuracy_json(const solver::AccuracyResult& result);

} // namespace hvi::lang
