// The report of a run, a check, a study or a stability report: one HTML file that needs no network.
#pragma once

#include "lang/script.hpp"
#include "solver/output/field_frame.hpp"
#include "solver/time/run.hpp"

#include <nlohmann/json.hpp>

#include <span>
#include <string>

namespace hvi::lang {

/// What a report is made of; what is not there has no section.
struct ReportParts {
  const Script& script;
  nlohmann::ordered_json hypotheses{}; ///< hvi-check/1
  nlohmann::ordered_json result{};     ///< hvi-result/1
  nlohmann::ordered_json study{};      ///< hvi-study/1
  nlohmann::ordered_json stability{};  ///< hvi-stability/1
  const solver::RunResult* run = nullptr;
  std::span<const solver::FieldFrame> frames{};
  int frames_since = 0; ///< of a run that is gone on from a checkpoint: its step
};

/// The page with its style, code and data in it. Texts of the script stand in the JSON only, where
/// no
/// `<` is left as it is, and the code never makes markup of them.
std::string report_page(const ReportParts& parts);

/// What the name of a report's file adds to that of the script.
inline constexpr const char* report_ending = "_report.html";

} // namespace hvi::lang
