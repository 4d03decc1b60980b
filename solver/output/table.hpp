// The table of a run: on the terminal and as CSV.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hvi::solver {

/// Columns of equal length under their names. A value that does not exist (yet) is NaN.
struct ReportTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  std::vector<std::string> units{}; ///< of the columns, "" where nobody knows; or none at all
};

/// Comma separated with a header; 17 significant digits, so reading it back gives the same numbers.
/// A missing value is an empty cell.
std::string csv_text(const ReportTable& table);
/// The same without the line of names.
std::string csv_rows(const ReportTable& table);

/// What is told of a column beside the table.
struct CsvColumn {
  std::string name;
  std::string unit;   ///< "" where nobody knows
  bool number = true; ///< else words
};
/// What the columns are in, as JSON beside the table: "Metadata Vocabulary for Tabular Data" (J.
/// Tennison, G. Kellogg, editors; W3C Recommendation, 17 December 2015), with `unitText` of
/// schema.org. Empty where no unit is known.
std::string csv_metadata(const std::string& file, const std::vector<CsvColumn>& columns);
/// Where those who read the table look for it.
std::string metadata_file(const std::string& file);
/// A table as text and its metadata into a folder; where no unit is known there is one file, and
/// metadata of an earlier run are removed. The names of the files. Throws Failure(output).
std::vector<std::string> write_csv(const std::filesystem::path& folder, const std::string& file,
                                   const std::string& text, const std::vector<CsvColumn>& columns);
std::vector<std::string> write_table(const std::filesystem::path& folder, const std::string& file,
                                     const ReportTable& table);

/// Aligned columns with 12 significant digits for people. A missing value is `-`. Beyond
/// `most_rows` the middle is left out and said so.
std::string aligned_text(const ReportTable& table, std::size_t most_rows = 40);

} // namespace hvi::solver
