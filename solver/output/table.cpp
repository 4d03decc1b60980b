// The table of a run: on the terminal and as CSV. Last stage of the pipeline.
#include "solver/output/table.hpp"

#include "solver/output/file.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>

namespace hvi::solver {
namespace {

std::size_t rows_of(const ReportTable& table) {
  return table.columns.empty() ? 0 : table.columns.front().size();
}

std::string csv_name(const std::string& name) {
  if (name.find_first_of(",\"\n\r") == std::string::npos) return name;
  std::string out = "\"";
  for (const char c : name) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

/// As %.{digits}g, in a quarter of its time.
void append(std::string& out, double value, int digits) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, digits);
  out.append(text.data(), end.ptr);
}

std::string twelve_digits(double value) {
  std::string out;
  append(out, value, 12);
  return out;
}

std::string padded_line(const std::vector<std::string>& cells,
                        const std::vector<std::size_t>& widths) {
  std::string line;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto characters = static_cast<std::size_t>(std::count_if(
        cells[c].begin(), cells[c].end(), [](char byte) { return (byte & 0xc0) != 0x80; }));
    if (c > 0) line += "  ";
    line.append(widths[c] - std::min(widths[c], characters), ' ');
    line += cells[c];
  }
  return line + "\n";
}

} // namespace

std::string csv_text(const ReportTable& table) {
  std::string out;
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    if (c > 0) out += ',';
    out += csv_name(table.names[c]);
  }
  return out + '\n' + csv_rows(table);
}

std::string csv_rows(const ReportTable& table) {
  std::string out;
  for (std::size_t r = 0; r < rows_of(table); ++r) {
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const double value = table.columns[c][r];
      if (c > 0) out += ',';
      if (!std::isnan(value)) append(out, value, 17);
    }
    out += '\n';
  }
  return out;
}

namespace {

constexpr const char* metadata_creator = "hvi-run";

/// Somebody else's file of that name is not.
bool is_own_metadata(const std::filesystem::path& file) {
  std::ifstream in(file);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  return json.is_object() && json.value("dc:creator", nlohmann::json()) == metadata_creator;
}

} // namespace

std::string metadata_file(const std::string& file) { return file + "-metadata.json"; }

std::string csv_metadata(const std::string& file, const std::vector<CsvColumn>& columns) {
  if (std::ranges::all_of(columns, [](const CsvColumn& c) { return c.unit.empty(); })) return {};
  using Json = nlohmann::ordered_json;
  Json described = Json::array();
  for (const CsvColumn& column : columns) {
    Json one{{"titles", column.name}, {"datatype", column.number ? "double" : "string"}};
    if (!column.unit.empty()) one["schema:unitText"] = column.unit;
    described.push_back(std::move(one));
  }
  const Json out{{"@context", "http://www.w3.org/ns/csvw"},
                 {"dc:creator", metadata_creator},
                 {"url", std::filesystem::path(file).filename().string()},
                 {"tableSchema", {{"columns", described}}}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::string> write_csv(const std::filesystem::path& folder, const std::string& file,
                                   const std::string& text, const std::vector<CsvColumn>& columns) {
  write_atomically(folder / file, text);
  const std::string about = metadata_file(file), metadata = csv_metadata(file, columns);
  if (!metadata.empty()) {
    write_atomically(folder / about, metadata);
    return {file, about};
  }
  std::error_code none;
  if (is_own_metadata(folder / about)) std::filesystem::remove(folder / about, none);
  return {file};
}

std::vector<std::string> write_table(const std::filesystem::path& folder, const std::string& file,
                                     const ReportTable& table) {
  std::vector<CsvColumn> columns;
  for (std::size_t c = 0; c < table.names.size(); ++c)
    columns.push_back({table.names[c], c < table.units.size() ? table.units[c] : ""});
  return write_csv(folder, file, csv_text(table), columns);
}

std::string aligned_text(const ReportTable& table, std::size_t most_rows) {
  const std::size_t rows = rows_of(table);
  const std::size_t head = rows > most_rows ? most_rows / 2 : rows;
  const std::size_t tail = rows > most_rows ? most_rows - head : 0;
  std::vector<std::vector<std::string>> lines{table.names};
  std::vector<std::size_t> widths;
  for (const auto& name : table.names) widths.push_back(name.size());
  for (std::size_t r = 0; r < rows; ++r) {
    if (r >= head && r < rows - tail) continue;
    std::vector<std::string> cells;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const double value = table.columns[c][r];
      cells.push_back(std::isnan(value) ? "-" : twelve_digits(value));
      widths[c] = std::max(widths[c], cells.back().size());
    }
    lines.push_back(std::move(cells));
  }
  std::string out;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    if (tail > 0 && l == head + 1) out += fmt::format("... {} rows ...\n", rows - head - tail);
    out += padded_line(lines[l], widths);
  }
  return out;
}

} // namespace hvi::solver
