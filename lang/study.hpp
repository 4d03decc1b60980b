// A study: the same script at many settings, with errors and costs side by side.
//
//   ladders -> settings -> runs (each with a gauge) -> rows -> table, CSV, JSON, pictures
#pragma once

#include "lang/check/model.hpp"
#include "lang/pictures.hpp"
#include "solver/output/table.hpp"
#include "solver/results/result_json.hpp"
#include "solver/study/cea.hpp"
#include "solver/study/ladder.hpp"

#include <nlohmann/json_fwd.hpp>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

/// One setting of a study and what it gave.
struct StudyRow {
  std::vector<int> rungs;                    ///< index into each ladder
  std::map<std::string, std::string> values; ///< parameter -> value, as a parameter is given
  std::optional<solver::StudyError> error;   ///< absent: failed, or the finest run itself
  std::vector<solver::StudyError> errors;    ///< of several unknowns: of each, in its own norm
  std::vector<std::optional<double>> orders; ///< of each of them
  /// Against `richardson`, on the diagonal: how far the next coarser run there is from this one, by
  /// unknown.
  std::vector<solver::StudyError> below;
  std::map<std::string, double> probes; ///< final values
  /// Their distances to the finest run's (extrapolated: errors), and the orders seen.
  std::map<std::string, double> probe_errors, probe_orders;
  std::optional<solver::CeaTerms> cea; ///< backward Euler only, which the theorem is about
  int unknowns = 0, steps = 0, newton = 0;
  double cpu = 0.0, wall = 0.0, peak_bytes = 0.0;
  std::optional<double> order; ///< against the setting one rung lower on every ladder
  bool front = false;          ///< no other setting is both cheaper and closer
  std::string failure;         ///< empty when certified
};

/// What a study has made of the distances of one kind to the finest run.
struct StudyExtrapolation {
  std::string of; ///< "V error", a probe, ...
  /// Absent: no order is seen, and the distances stand as they are.
  std::optional<solver::Richardson> law;
};

struct Study {
  std::string script, reference;    ///< the reference in words
  bool sweep = false;               ///< there is none: the columns are what is asked for
  std::vector<std::string> columns; ///< of the tables
  /// Of parameters and columns by their names; none for scripts without units.
  solver::UnitsByName units;
  /// The same of "params", "variables" and "columns", which may have names in common.
  std::map<std::string, solver::UnitsByName> units_by_kind;
  std::vector<StudyLadder> ladders;
  std::vector<std::string> unknowns; ///< where there are several
  std::optional<std::size_t> in;     ///< which of them the error is of; none: of all together
  std::vector<StudyRow> rows;
  std::string machine;
  /// What settings took over from earlier ones instead of computing it.
  struct Shared {
    int meshes = 0, matrices = 0, orders = 0, factors = 0;
    double seconds = 0.0; ///< CPU, without the meshes
  } shared;
  /// Probes are judged by the finest run; absent when it failed.
  std::optional<std::size_t> finest;
  std::vector<StudyExtrapolation> extrapolated; ///< where errors are
};

/// Is a row on the diagonal of the ladders of numbers, which gives orders, below the finest run?
bool below_finest(const Study& study, const StudyRow& row);

/// From the rows as they were run: distances of the probes to the finest run, orders, the front;
/// with `richardson` the errors are extrapolated from the distances.
void judge(Study& study, bool richardson);

/// Text for a terminal; CSV; schema hvi-study/1.
std::string study_table(const Study& study);
std::string study_csv(const Study& study);
/// Of the same table, with what they are in.
std::vector<solver::CsvColumn> study_columns(const Study& study);
nlohmann::ordered_json study_json(const Study& study);
/// Every varied parameter, ladder by ladder.
std::vector<std::string> varied(const Study& study);
/// "force [N]"; the name alone where there is no unit to tell.
std::string with_parameter_unit(const Study& study, const std::string& name);
std::string with_column_unit(const Study& study, const std::string& name);
/// "mm" of `name`, which is one of "params", "variables" or "columns"; "" where it is not known.
std::string unit_in(const Study& study, const char* kind, const std::string& name);
/// Of a sweep: the columns at the end, setting by setting.
std::string sweep_table(const Study& study);
/// Curves of a column at the end over the first parameter with numbers; empty: there is none.
std::string sweep_picture(const Study& study, const std::string& column);
/// Error against CPU time with the front, and error against each ladder's numbers with triangles of
/// slopes one and two, each as SVG and PNG, drawn by gnuplot into `folder`. Rungs that are no
/// positive numbers have no place on the axis.
std::vector<Drawn> draw_study(const Study& study, const std::string& folder);
/// The names of all files that a study writes into its folder, but for its journal.
std::vector<std::string> files_of_study(const Study& study);

} // namespace hvi::lang
