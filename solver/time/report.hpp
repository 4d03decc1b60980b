// What a run reports while it goes: table rows, field files, probes, effects that stayed asleep.
#pragma once

#include "solver/output/table.hpp"
#include "solver/time/field_files.hpp"
#include "solver/time/probes.hpp"

#include <optional>

namespace hvi::solver {

class Reporter {
public:
  Reporter(const Plan& plan, const Discretisation& discretisation, const Stepper& stepper,
           const RunSettings& settings);

  /// Records an accepted step: rows and files that are due (`last`: all of them).
  void record(const Stepper& stepper, bool last);
  /// Writes what is kept in memory so far (tables); also after a failure.
  void finish(RunResult& result);

private:
  struct TableFile {
    std::vector<int> probes;
    int every;
    std::string file;
  };
  void prepare_tables(const std::string& name);
  void prepare_fields(const Discretisation& discretisation, const Stepper& stepper,
                      const std::string& name);
  void timed_probes(const Stepper& stepper);
  void note_multipliers(const Stepper& stepper);
  void effects(RunResult& result) const;
  void write_table(const TableFile& table);
  bool due(int every, int step, bool last) const { return last || step % every == 0; }

  const Plan& plan_;
  const Contact& contact_;
  std::filesystem::path folder_;
  bool writes_;
  ProbeSet probes_;
  std::vector<TableFile> tables_;
  std::vector<std::pair<int, FieldFiles>> fields_; ///< every, files
  Snapshot now_, before_, between_;
  bool keeps_before_ = false;
  int base_every_ = 0; ///< greatest common divisor of the tables' `every`
  std::vector<double> values_;
  std::vector<int> rows_; ///< steps recorded
  std::vector<double> times_;
  std::vector<std::vector<double>> columns_; ///< by probe
  std::vector<char> active_;                 ///< by law term: was its multiplier ever non-zero
  std::vector<std::string> written_;
  int last_recorded_ = -1;
};

} // namespace hvi::solver
