// What a run reports while it goes: table rows, field files, probes, effects that stayed asleep.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/effects.hpp"
#include "solver/results/field_files.hpp"
#include "solver/results/probes.hpp"
#include "solver/results/run_pictures.hpp"
#include "solver/results/run_result.hpp"
#include "solver/results/run_settings.hpp"
#include "solver/results/run_tables.hpp"
#include "solver/results/table_ranges.hpp"
#include "solver/results/written_files.hpp"

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// What displacements are compared with: the largest |u| of the run, and what is rounding of it.
struct SolutionSize {
  double size = 0.0;
  double nothing = 0.0;
  /// Of several unknowns, what is rounding of each.
  ByUnknown nothing_of{};
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
  /// By probe, at the last step that had a row, or with RunSettings::every_value the last one; NaN
  /// where the time of one has not come.
  std::span<const double> values() const { return values_; }
  /// Notes the events of a step: the next row counts those since the last one.
  void mark(const StepResult& outcome) { tables_.mark(outcome); }
  /// What these errors make of the columns, to first order at the last state u (all dofs). After
  /// `record` of the last step.
  std::vector<ColumnError> errors(std::span<const ErrorSample> samples, const Vector& u,
                                  SolutionSize scale);
  /// Writes the tables as far as they are, up to this step (run_tables.hpp).
  void stream(int step, bool with_events) { tables_.stream(step, with_events, files_); }
  /// Writes what is kept in memory so far (tables); also after a failure.
  void finish(RunResult& result);
  WrittenFiles& files() { return files_; }

  void save(std::ostream& out) const;
  /// `run`: restored before. Throws Failure(broken_file) when a file written before is gone or
  /// not what it was.
  void restore(std::istream& in, const RunState& run);

private:
  struct FieldSeries {
    int every;
    bool from_start;
    FieldFiles files;
  };
  void prepare_fields(const RunState& run, const RunSettings& settings);
  void read_between_steps(const RunState& run);
  double of_steps_at(int i, double share);
  std::vector<double> change_along(const ErrorSample& direction, double step);
  void write_fields(FieldSeries& series);
  void add_row(const RunState& run);

  const Plan& plan_;
  const Discretisation& discretisation_;
  const Contact& contact_;
  std::string name_; ///< of files without a name of their own
  std::filesystem::path folder_;
  ProbeSet probes_;
  TableRanges tables_read_;
  WrittenFiles files_;
  RunTables tables_;
  std::vector<FieldSeries> fields_;
  RunPictures pictures_;
  Snapshot now_, before_, between_;
  Snapshot start_; ///< with what is not known at the initial time, where something is asked between
  bool keeps_before_ = false, rows_read_interior_ = false, every_value_ = false;
  bool balance_at_start_ = false;
  std::vector<double> values_; ///< by probe
  bool ended_ = false;         ///< the last step is recorded
  int last_recorded_ = -1;
  LawRange range_;
  std::vector<EffectNote> found_; ///< effects that only the matrices and loads show
};

} // namespace hvi::solver
