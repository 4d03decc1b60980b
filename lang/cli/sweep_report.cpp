// A study without a reference as a table and as curves (study.hpp).
#include "lang/gnuplot.hpp"
#include "lang/study.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>

namespace hvi::lang {

namespace {

/// A parameter's value as a number; words have none.
std::optional<double> number_of(const std::string& value) {
  char* end = nullptr;
  const double out = std::strtod(value.c_str(), &end);
  if (value.empty() || *end != '\0' || !std::isfinite(out)) return std::nullopt;
  return out;
}

/// The first ladder whose values are numbers, at least two different ones.
std::optional<std::size_t> ladder_of_numbers(const Study& study) {
  for (std::size_t l = 0; l < study.ladders.size(); ++l) {
    const auto& values = study.ladders[l].values;
    bool all = values.size() > 1, differ = false;
    for (const std::string& value : values) {
      all = all && number_of(value);
      differ = differ || value != values.front();
    }
    if (all && differ) return l;
  }
  return std::nullopt;
}

/// What the other ladders have in a row: the name of its curve.
std::string others(const Study& study, const StudyRow& row, std::size_t along) {
  std::string out;
  for (std::size_t l = 0; l < study.ladders.size(); ++l)
    if (l != along)
      out += fmt::format("{}{} = {}", out.empty() ? "" : ", ", study.ladders[l].parameter,
                         row.values.at(study.ladders[l].parameter));
  return out;
}

} // namespace

std::string sweep_table(const Study& study) {
  std::vector<std::vector<std::string>> grid(1);
  for (const auto& name : varied(study)) grid[0].push_back(with_parameter_unit(study, name));
  for (const auto& name : study.columns) grid[0].push_back(with_column_unit(study, name));
  for (const char* name : {"unknowns", "CPU s"}) grid[0].emplace_back(name);
  for (const StudyRow& row : study.rows) {
    auto& line = grid.emplace_back();
    for (const auto& name : varied(study)) line.push_back(row.values.at(name));
    for (const auto& name : study.columns) {
      const auto value = row.probes.find(name);
      line.push_back(value == row.probes.end() ? "-" : fmt::format("{:.9g}", value->second));
    }
    line.push_back(fmt::format("{}", row.unknowns));
    line.push_back(fmt::format("{:.3g}", row.cpu));
  }
  std::vector<std::size_t> widths(grid[0].size(), 0);
  for (const auto& line : grid)
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  std::string out = fmt::format("{}: the columns at the end\n", study.script);
  for (const auto& line : grid) {
    for (std::size_t c = 0; c < line.size(); ++c)
      out += fmt::format("{}{:>{}}", c > 0 ? "  " : "", line[c], widths[c]);
    out += "\n";
  }
  for (const StudyRow& row : study.rows) {
    if (row.failure.empty()) continue;
    out += "failed:";
    for (const auto& [name, value] : row.values) out += fmt::format(" {} = {}", name, value);
    out += ": " + row.failure + "\n";
  }
  return out + study.machine + "\n";
}

std::string sweep_picture(const Study& study, const std::string& column) {
  const auto along = ladder_of_numbers(study);
  if (!along) return {};
  const std::string& parameter = study.ladders[*along].parameter;
  std::map<std::string, std::string> curves; // by name: their points
  for (const StudyRow& row : study.rows)
    if (const auto value = row.probes.find(column); value != row.probes.end())
      curves[others(study, row, *along)] +=
          fmt::format("{:.10g} {:.10g}\n", *number_of(row.values.at(parameter)), value->second);
  if (curves.empty()) return {};
  std::string data, plots;
  int k = 0;
  for (const auto& [name, points] : curves) {
    data += fmt::format("$curve{} << HVI_END\n{}HVI_END\n", k, points);
    plots += fmt::format("{}$curve{} with linespoints pt 7 ps 0.6 {}", k > 0 ? ", " : "", k,
                         name.empty() ? "notitle" : "title " + quoted(name) + " noenhanced");
    ++k;
  }
  return fmt::format("{}set title {} noenhanced\nset grid\nset key outside right top\n"
                     "set xlabel {} noenhanced\nset ylabel {} noenhanced\nplot {}\n",
                     data, quoted(std::filesystem::path(study.script).filename().string()),
                     quoted(with_parameter_unit(study, parameter)),
                     quoted(with_column_unit(study, column)), plots);
}

} // namespace hvi::lang
