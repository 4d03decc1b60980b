// `--accuracy X --of NAME` and `using accuracy = X`: what is asked for, and the evidence as text
// and JSON. Between the run command and solver/study/accuracy.hpp.
#pragma once

#include "lang/driver.hpp"
#include "solver/study/accuracy.hpp"

#include <functional>
#include <optional>
#include <string>

namespace hvi::lang {

/// What the command line wants, else the script. Throws Failure(bad_value) for a column that the
/// report does not have.
std::optional<solver::AccuracyRequest> accuracy_request(const Script& script,
                                                        const Options& options);
/// Lines of progress on stderr, unless --quiet.
std::function<void(const std::string&)> accuracy_teller(const Options& options);
/// The runs that were made, the settings chosen, and the verdict.
std::string accuracy_text(const solver::AccuracyResult& result);
/// A result (schema hvi-result/1) with its member `accuracy`.
std::string with_accuracy(const std::string& result_json, const solver::AccuracyResult& result);

} // namespace hvi::lang
