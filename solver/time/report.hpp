// What a run reports while it goes: table rows, field files, probes, effects that stayed asleep.
#pragma once

#include "solver/output/table.hpp"
#include "solver/time/effects.hpp"
#include "solver/time/field_files.hpp"
#include "solver/time/line_values.hpp"
#include "solver/time/probes.hpp"
#include "solver/time/shown.hpp"

#include <array>
#include <chrono>
#include <functional>
#include <optional>
#include <span>

namespace hvi::solver {

/// Where several solutions are possible tables have a column more: points released at downward
/// jumps since the last row, or -1 for a snap without one.
inline constexpr const char* event_column = "event";
/// Does the table have it? Not where a probe has the name.
bool shows_events(const RunResult& result);

/// Names without extension, in the output folder, of the i-th table and of the i-th fields.
std::string table_stem(const ReportSpec& report, std::size_t i, const std::string& name);
std::string fields_stem(const ReportSpec& report, std::size_t i, const std::string& name);

/// What displacements are compared with: the largest |u| of the run, and what is rounding of it.
struct SolutionSize {
  double size = 0.0;
  double nothing = 0.0;
  /// Of several unknowns, what is rounding of each.
  std::array<double, slot::most_unknowns> nothing_of{};
  double nothing_of_multipliers = 0.0;
};

class Reporter {
public:
  /// `shown`: null where nothing is.
  Reporter(const Plan& plan, const Discretisation& discretisation, const RunState& run,
           const RunSettings& settings, Shown* shown = nullptr);

  /// Before the first step: the initial state, where tables or files begin with it. What is not
  /// known at the initial time is NaN: rates of problems without u'', multipliers and reactions,
  /// unless the run starts in a balance of forces.
  void begin(const RunState& run);
  /// The problem has other loads than before.
  void take_loads() { probes_.take_loads(); }
  /// Records an accepted step: rows and files that are due (`last`: all of them).
  void record(const RunState& run, bool last);
  /// By probe, at the last step that had a row; NaN where the time of one has not come.
  std::span<const double> values() const { return values_; }
  /// Notes the events of a step: the next row counts those since the last one.
  void mark(const StepResult& outcome);
  /// What these errors make of the columns, to first order at the last state u (all dofs). After
  /// `record` of the last step.
  std::vector<ColumnError> errors(std::span<const ErrorSample> samples, const Vector& u,
                                  SolutionSize scale);
  /// Writes the tables as far as they are, up to this step, when that has not been done for a
  /// second (or for twenty times as long as it takes).
  void stream(int step, bool with_events);
  /// Writes what is kept in memory so far (tables); also after a failure.
  void finish(RunResult& result);
  /// Writes something. What cannot be written is told, and the run goes on.
  void attempt(const std::function<void()>& write);
  void tell_unwritten(RunResult& result) const { result.unwritten = unwritten_; }

  void save(std::ostream& out) const;
  /// `run`: restored before. Throws Failure(broken_file) when a file written before is gone or
  /// not what it was.
  void restore(std::istream& in, const RunState& run);

private:
  struct TableFile {
    std::vector<int> probes;
    int every;
    bool from_start;
    std::string file;
    std::size_t streamed = 0; ///< rows recorded that were looked at for the file; 0: no file yet
    bool streamed_events = false; ///< the file has the column of events
  };
  void prepare_tables(const std::string& name);
  void prepare_fields(const Discretisation& discretisation, const RunState& run,
                      const RunSettings& settings);
  void read_between_steps(const RunState& run);
  void read_of_steps(int i, double share);
  void show(std::size_t picture, const Snapshot& snapshot);
  void show_at_end();
  std::vector<double> change_along(const ErrorSample& direction, double step);
  /// The rows recorded from `first` up to `end` that the table has; `ends`: the last one of all is
  /// in it.
  ReportTable table_rows(const TableFile& table, std::size_t first, std::size_t end,
                         bool with_events, bool ends) const;
  void note_written(const std::vector<std::string>& files);
  void stream_table(TableFile& table, std::size_t rows, bool with_events);
  bool due(int every, int step, bool last) const { return last || step % every == 0; }
  bool has_row(const TableFile& table, int step, bool last) const {
    return step > 0 ? due(table.every, step, last) : table.from_start;
  }
  void add_row(const RunState& run);

  const Plan& plan_;
  const Discretisation& discretisation_;
  const Space& space_; ///< of it
  const Contact& contact_;
  std::string name_; ///< of files without a name of their own
  std::filesystem::path folder_;
  bool writes_;
  ProbeSet probes_;
  std::vector<TableFile> tables_;
  struct FieldSeries {
    int every;
    bool from_start;
    FieldFiles files;
  };
  std::vector<FieldSeries> fields_;
  Snapshot now_, before_, between_;
  bool keeps_before_ = false, rows_read_interior_ = false;
  int base_every_ = 0; ///< greatest common divisor of the tables' `every`
  std::vector<double> values_;
  std::vector<int> rows_; ///< steps recorded
  std::vector<double> times_;
  std::vector<std::vector<double>> columns_; ///< by probe
  std::vector<PictureValues> pictures_;      ///< by picture, when its time has come
  std::vector<LineValues> lines_;
  std::optional<ShownFrames> shown_;
  bool ended_ = false; ///< the last step is recorded
  LawRange range_;
  std::vector<EffectNote> found_; ///< effects that only the matrices and loads show
  std::vector<std::string> written_;
  int last_recorded_ = -1;
  std::vector<int> events_; ///< by row: points released, or -1 for a snap
  int pending_events_ = 0;
  std::function<void(const std::string&)> warn_;
  std::optional<Failure> unwritten_; ///< of the first file that could not be written
  std::chrono::steady_clock::time_point streamed_ = std::chrono::steady_clock::now();
};

} // namespace hvi::solver
