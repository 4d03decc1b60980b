// The files, in the output folder, that the results of a report are written to.
#pragma once

#include "solver/plan/report.hpp"

#include <string>
#include <vector>

namespace hvi::solver {

/// Names of the i-th table, picture, ...: those of the report, or names of their own that begin
/// with the title.
std::string table_file(const ReportSpec& report, std::size_t i, const std::string& title);
std::string line_file(const ReportSpec& report, std::size_t i, const std::string& title);
std::string picture_file(const ReportSpec& report, std::size_t i, const std::string& title);
std::string plot_file(const ReportSpec& report, std::size_t i, const std::string& title);
std::string graphs_file(const ReportSpec& report, std::size_t i, const std::string& title);
/// Of the i-th fields, without extension.
std::string fields_stem(const ReportSpec& report, std::size_t i, const std::string& title);
/// What the names of a grid's files begin with, before _00001; `grid`: empty for the body's.
std::string series_stem(const std::string& fields_stem, const std::string& grid);

/// What one result writes.
struct ResultFiles {
  Origin origin;
  std::string file;                  ///< a table, a picture, or the collection of fields
  bool columns = false;              ///< it has columns, whose units stand in a file beside it
  std::vector<std::string> series{}; ///< of fields: stems of NAME_00001.vtu, NAME_00001.pvtu, ...
};
/// Of all results; of pictures side by side one.
std::vector<ResultFiles> result_files(const ReportSpec& report, const std::string& title);

/// Is it NAME_00001.vtu, NAME_00001.pvtu or the like?
bool in_series(const std::string& file, const std::string& stem);
/// A file that both write; "": there is none.
std::string shared_file(const ResultFiles& a, const ResultFiles& b);

} // namespace hvi::solver
