// The tables of a run: the rows of all probes, and the files that show some of them.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/output/table.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/written_files.hpp"
#include "solver/step/step.hpp"

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// Where several solutions are possible tables have a column more: points released at downward
/// jumps since the last row, or -1 for a snap without one.
inline constexpr const char* event_column = "event";
/// Does the table have it? Not where a probe has the name.
bool shows_events(const RunResult& result);

/// Is something that is written every so many steps written at this one?
inline bool is_due(int every, int step, bool last) { return last || step % every == 0; }

class RunTables {
public:
  /// `report` outlives it; `folder`: empty where nothing is written; `name`: of files without a
  /// name of their own.
  RunTables(const ReportSpec& report, const std::string& name, std::filesystem::path folder);

  /// Does any table begin with the initial state?
  bool from_start() const;
  bool due(int step, bool last) const { return every_ > 0 && is_due(every_, step, last); }
  void add_row(int step, double t, std::span<const double> values);
  /// Notes the events of a step: the next row counts those since the last one.
  void mark(const StepResult& outcome);
  /// The values of a probe by row.
  std::span<const double> column(std::size_t probe) const { return columns_[probe]; }

  /// Writes the tables as far as they are, up to this step, when that has not been done for a
  /// tenth of a second.
  void stream(int step, bool with_events, WrittenFiles& files);
  /// The columns, and the tables' files.
  void finish(RunResult& result, WrittenFiles& files) const;

  void save(StateWriter& w) const;
  /// `step`: of the state.
  void restore(StateReader& r, int step);

private:
  struct File {
    std::vector<int> probes;
    int every;
    bool from_start;
    std::string name;
    std::size_t streamed = 0; ///< rows recorded that were looked at for the file; 0: no file yet
    bool streamed_events = false; ///< the file has the column of events
  };
  bool has_row(const File& file, int step, bool last) const {
    return step > 0 ? is_due(file.every, step, last) : file.from_start;
  }
  /// The rows recorded from `first` up to `end` that the file has; `ends`: the last one of all is
  /// in it.
  ReportTable rows_of(const File& file, std::size_t first, std::size_t end, bool with_events,
                      bool ends) const;
  void note_missing(std::size_t probe, RunResult& result) const;
  void stream_file(File& file, std::size_t rows, bool with_events) const;

  const ReportSpec& report_;
  std::filesystem::path folder_;
  std::vector<File> files_;
  int every_ = 0;          ///< greatest common divisor of the tables' `every`
  std::vector<int> steps_; ///< by row
  std::vector<double> times_;
  std::vector<std::vector<double>> columns_; ///< by probe
  std::vector<int> events_;                  ///< by row: points released, or -1 for a snap
  int pending_events_ = 0;
  std::chrono::steady_clock::time_point streamed_ = std::chrono::steady_clock::now();
};

} // namespace hvi::solver
