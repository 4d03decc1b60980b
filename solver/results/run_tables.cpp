// See run_tables.hpp. Used by the Reporter.
#include "solver/results/run_tables.hpp"

#include "solver/output/file.hpp"
#include "solver/plan/result_files.hpp"
#include "solver/results/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>

namespace hvi::solver {
namespace {

/// More points than a body has; sums of two counts are still numbers.
constexpr int most_events = 1 << 30;

bool is_no_count(int events) { return events < -1 || events > most_events; }

} // namespace

bool shows_events(const RunResult& result) {
  return !result.unique && !result.events.empty() && !result.columns.contains(event_column);
}

RunTables::RunTables(const ReportSpec& report, const std::string& name,
                     std::filesystem::path folder)
    : report_(report), folder_(std::move(folder)), columns_(report.probes.size()) {
  for (std::size_t i = 0; i < report.tables.size(); ++i) {
    const auto& spec = report.tables[i];
    files_.push_back(
        {spec.probes, std::max(spec.every, 1), spec.from_start, table_file(report, i, name)});
    every_ = std::gcd(every_, files_.back().every);
  }
}

bool RunTables::from_start() const {
  return std::ranges::any_of(files_, [](const File& file) { return file.from_start; });
}

void RunTables::add_row(int step, double t, std::span<const double> values) {
  steps_.push_back(step);
  times_.push_back(t);
  events_.push_back(std::exchange(pending_events_, 0));
  for (std::size_t i = 0; i < values.size(); ++i) columns_[i].push_back(values[i]);
}

void RunTables::mark(const StepResult& outcome) {
  if (outcome.inequality.events > 0)
    pending_events_ = std::max(pending_events_, 0) + outcome.inequality.events;
  else if (outcome.snap && pending_events_ == 0)
    pending_events_ = -1;
}

void RunTables::stream(int step, bool with_events, WrittenFiles& files) {
  if (folder_.empty() || files_.empty()) return;
  constexpr std::chrono::milliseconds pause(100); // shorter runs write their tables once
  const auto now = std::chrono::steady_clock::now();
  if (now - streamed_ < pause) return;
  const auto rows = static_cast<std::size_t>(std::upper_bound(steps_.begin(), steps_.end(), step) -
                                             steps_.begin());
  for (auto& file : files_)
    if (rows > file.streamed) files.attempt([&] { stream_file(file, rows, with_events); });
  streamed_ = now;
}

/// The first time the whole table, then the rows that are new, at the end of the file.
void RunTables::stream_file(File& file, std::size_t rows, bool with_events) const {
  const std::size_t first = file.streamed_events == with_events ? file.streamed : 0;
  const ReportTable more = rows_of(file, first, rows, with_events, false);
  file.streamed = 0; // where writing fails
  if (first == 0)
    write_table(folder_, file.name, more);
  else if (const std::string lines = csv_rows(more); !lines.empty())
    append_line(folder_ / file.name, std::string_view(lines).substr(0, lines.size() - 1),
                Durability::ordinary);
  file.streamed = rows;
  file.streamed_events = with_events;
}

ReportTable RunTables::rows_of(const File& file, std::size_t first, std::size_t end,
                               bool with_events, bool ends) const {
  ReportTable out{{"t"}, {{}}, {report_.unit_of_time}};
  for (const int probe : file.probes) {
    out.names.push_back(report_.probes[probe].name);
    out.units.push_back(report_.probes[probe].unit);
  }
  if (with_events) out.names.emplace_back(event_column);
  out.units.resize(out.names.size());
  out.columns.resize(out.names.size());
  std::int64_t events = 0; // of the rows that this table leaves out, too
  while (first > 0 && !has_row(file, steps_[first - 1], false)) --first; // their events
  for (std::size_t r = first; r < end; ++r) {
    if (events_[r] > 0) events = std::max<std::int64_t>(events, 0) + events_[r];
    if (events_[r] < 0) events = events_[r];
    if (!has_row(file, steps_[r], ends && r + 1 == steps_.size())) continue;
    if (with_events) out.columns.back().push_back(static_cast<double>(std::exchange(events, 0)));
    out.columns[0].push_back(times_[r]);
    for (std::size_t c = 0; c < file.probes.size(); ++c)
      out.columns[c + 1].push_back(columns_[file.probes[c]][r]);
  }
  return out;
}

/// The first row in which a probe that is due has no value, and how many more there are.
void RunTables::note_missing(std::size_t probe, RunResult& result) const {
  const auto& spec = report_.probes[probe];
  std::vector<std::size_t> rows;
  for (std::size_t r = 0; r < steps_.size(); ++r)
    if (steps_[r] > 0 && !(spec.time && times_[r] < *spec.time) &&
        !std::isfinite(columns_[probe][r]))
      rows.push_back(r);
  if (rows.empty()) return;
  const std::string where =
      rows.size() == 1 ? " in this row"
                       : fmt::format(" in {} rows, of which this is the first", rows.size());
  result.notes.push_back({steps_[rows.front()], times_[rows.front()],
                          fmt::format("`{}` has no finite value{}", spec.name, where),
                          spec.origin});
}

void RunTables::finish(RunResult& result, WrittenFiles& files) const {
  std::set<int> shown;
  for (const auto& file : files_)
    for (const int probe : file.probes)
      if (shown.insert(probe).second) result.column_order.push_back(report_.probes[probe].name);
  result.times = times_;
  result.events = events_;
  for (const int probe : shown) {
    result.columns[report_.probes[probe].name] = columns_[probe];
    note_missing(static_cast<std::size_t>(probe), result);
  }
  if (folder_.empty() || steps_.empty()) return;
  const bool with_events = shows_events(result);
  for (const auto& file : files_)
    files.attempt([&] {
      files.add(
          write_table(folder_, file.name, rows_of(file, 0, steps_.size(), with_events, true)));
    });
}

void RunTables::save(StateWriter& w) const {
  w.put(steps_);
  w.put(times_);
  for (const auto& column : columns_) w.put(column);
  w.put(events_);
  w.put(pending_events_);
}

void RunTables::restore(StateReader& r, int step) {
  steps_ = r.get_vector<int>();
  if (!steps_.empty() && (steps_.front() < (from_start() ? 0 : 1) || steps_.back() > step ||
                          std::ranges::adjacent_find(steps_, std::greater_equal{}) != steps_.end()))
    r.fail("is inconsistent");
  times_ = r.get_vector<double>(steps_.size());
  for (auto& column : columns_) column = r.get_vector<double>(steps_.size());
  events_ = r.get_vector<int>(steps_.size());
  pending_events_ = r.get<int>();
  if (std::ranges::any_of(events_, is_no_count) || is_no_count(pending_events_))
    r.fail("is inconsistent");
}

} // namespace hvi::solver
