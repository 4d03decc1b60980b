// The table of a run: on the terminal and as CSV.
#pragma once

#include <string>
#include <vector>

namespace hvi::solver {

/// Columns of equal length under their names. A value that does not exist (yet) is NaN.
struct ReportTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
};

/// Comma separated with a header; 17 significant digits, so reading it back gives the same numbers.
/// A missing value is an empty cell.
std::string csv_text(const ReportTable& table);
/// The same without the line of names.
std::string csv_rows(const ReportTable& table);

/// Aligned columns with 12 significant digits for people. A missing value is `-`. Beyond
/// `most_rows` the middle is left out and said so.
std::string aligned_text(const ReportTable& table, std::size_t most_rows = 40);

} // namespace hvi::solver
