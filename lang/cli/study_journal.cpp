// See study_journal.hpp.
#include "lang/cli/study_journal.hpp"

#include "lang/cli/say.hpp"
#include "solver/common/hash.hpp"
#include "solver/output/file.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <utility>

namespace hvi::lang {

namespace {

std::string checksum(const std::string& text) {
  return fmt::format("{:016x}", solver::hash_of(text));
}

nlohmann::json numbers(const solver::StudyError& e) {
  return {e.v_max, e.v_final, e.l2_max, e.l2_final, e.size};
}
solver::StudyError error_from(const nlohmann::json& e) { return {e[0], e[1], e[2], e[3], e[4]}; }

/// Throws where a number is none: JSON has no infinite ones.
void restore(const nlohmann::json& entry, StudyRow& row) {
  if (entry.contains("error")) row.error = error_from(entry["error"]);
  if (entry.contains("errors")) {
    row.errors.clear();
    for (const auto& e : entry["errors"]) row.errors.push_back(error_from(e));
    if (!entry.contains("error")) row.error = solver::together(row.errors);
  }
  row.below.clear();
  if (entry.contains("below"))
    for (const auto& e : entry["below"]) row.below.push_back(error_from(e));
  if (entry.contains("cea")) {
    const auto& c = entry["cea"];
    row.cea = solver::CeaTerms{c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]};
  }
  row.probes = entry["probes"].get<std::map<std::string, double>>();
  row.unknowns = entry["unknowns"], row.steps = entry["steps"], row.newton = entry["newton"];
  row.cpu = entry["cpu"], row.wall = entry["wall"], row.peak_bytes = entry["peak_bytes"];
  row.failure = entry["failure"];
}

} // namespace

void StudyJournal::read(const std::string& deciding, std::vector<StudyRow>& rows) {
  fingerprint_ = checksum(deciding);
  std::ifstream in(file_);
  for (std::string line; std::getline(in, line);) {
    auto entry = nlohmann::json::parse(line, nullptr, false);
    if (!entry.is_object() || entry.value("fingerprint", "") != fingerprint_) continue;
    const std::string written = entry.value("checksum", "");
    entry.erase("checksum");
    if (written != checksum(entry.dump())) continue;
    for (StudyRow& row : rows)
      if (entry.value("values", std::map<std::string, std::string>{}) == row.values) {
        StudyRow known = row;
        try {
          restore(entry, known);
        } catch (const nlohmann::json::exception&) {
          continue; // it is run again
        }
        row = std::move(known);
        done_.push_back(row.values);
      }
  }
}

bool StudyJournal::has(const StudyRow& row) const {
  return std::ranges::find(done_, row.values) != done_.end();
}

void StudyJournal::keep(const StudyRow& row) {
  done_.push_back(row.values);
  nlohmann::json entry = {{"fingerprint", fingerprint_},
                          {"values", row.values},
                          {"probes", row.probes},
                          {"unknowns", row.unknowns},
                          {"steps", row.steps},
                          {"newton", row.newton},
                          {"cpu", row.cpu},
                          {"wall", row.wall},
                          {"peak_bytes", row.peak_bytes},
                          {"failure", row.failure}};
  if (!row.errors.empty()) // of all together there may be no L2 error, which JSON has no number for
    for (const auto& e : row.errors) entry["errors"].push_back(numbers(e));
  else if (const auto& e = row.error)
    entry["error"] = numbers(*e);
  for (const auto& e : row.below) entry["below"].push_back(numbers(e));
  if (const auto& c = row.cea)
    entry["cea"] = {c->interpolation,
                    c->interpolation_rate,
                    c->trace,
                    c->residual,
                    c->largest_residual,
                    c->rate,
                    c->start,
                    c->step};
  entry["checksum"] = checksum(entry.dump());
  // Without it a later call runs the row again: no reason to stop this study.
  try {
    solver::append_line(file_, entry.dump());
  } catch (const solver::Failure& failure) {
    if (!std::exchange(warned_, true)) tell("warning: {}; the study goes on\n", failure.what());
  }
}

} // namespace hvi::lang
