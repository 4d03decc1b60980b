// See result_files.hpp.
#include "solver/plan/result_files.hpp"

#include "solver/kernel/slot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <span>

namespace hvi::solver {
namespace {

std::string stem_of(const std::string& file, const std::string& fallback) {
  if (file.empty()) return fallback;
  const std::filesystem::path path(file);
  return (path.parent_path() / path.stem()).string();
}

/// "", "2", "3", ...
std::string number_of(std::size_t i) { return i == 0 ? "" : fmt::format("{}", i + 1); }

std::string stem_of_picture(const PictureSpec& picture, const std::string& title) {
  return fmt::format("{}_{}{}{}", title, picture.field.name,
                     picture.deformed != 0.0 ? "_deformed" : "",
                     picture.in_row > 1 ? "_row"
                     : picture.time     ? fmt::format("_t{:g}", *picture.time)
                                        : "");
}

/// Has it a grid of its own: at the points of laws or of states?
bool is_off_the_body(const FieldSpec& field) {
  return std::ranges::any_of(field.components, [](const Expr& e) {
    return e.depends_on_any(slot::first_multiplier, slot::first_inside) ||
           e.depends_on_any(slot::first_state, slot::first_probe);
  });
}

std::vector<std::string> series_of(const FieldsSpec& fields, const std::string& stem) {
  std::vector<std::string> out;
  if (!std::ranges::all_of(fields.fields, is_off_the_body)) out.push_back(series_stem(stem, ""));
  for (const FieldSpec& field : fields.fields)
    if (is_off_the_body(field)) out.push_back(series_stem(stem, field.name));
  return out;
}

} // namespace

std::string table_file(const ReportSpec& report, std::size_t i, const std::string& title) {
  const std::string own = i == 0 ? title : title + "_table" + number_of(i);
  return stem_of(report.tables[i].file, own) + ".csv";
}

std::string fields_stem(const ReportSpec& report, std::size_t i, const std::string& title) {
  return stem_of(report.fields[i].file, i == 0 ? title : title + "_fields" + number_of(i));
}

std::string line_file(const ReportSpec& report, std::size_t i, const std::string& title) {
  return stem_of(report.lines[i].file, title + "_line" + number_of(i)) + ".csv";
}

std::string plot_file(const ReportSpec& report, std::size_t i, const std::string& title) {
  const std::string& given = report.plots[i].file;
  return given.empty() ? title + "_plot" + number_of(i) + ".svg" : given;
}

std::string graphs_file(const ReportSpec& report, std::size_t i, const std::string& title) {
  const GraphsSpec& spec = report.graphs[i];
  if (!spec.file.empty()) return spec.file;
  std::string out = title;
  for (const auto& graph : spec.graphs) out += "_" + graph.name;
  return out + ".png";
}

std::string picture_file(const ReportSpec& report, std::size_t i, const std::string& title) {
  const auto& pictures = report.pictures;
  if (!pictures[i].file.empty()) return pictures[i].file;
  const std::string own = stem_of_picture(pictures[i], title);
  const auto before =
      std::ranges::count_if(std::span(pictures).first(i), [&](const PictureSpec& other) {
        return other.in_row > 0 && other.file.empty() && stem_of_picture(other, title) == own;
      });
  return own + (before > 0 ? fmt::format("_{}.png", before + 1) : ".png");
}

std::string series_stem(const std::string& fields_stem, const std::string& grid) {
  if (grid.empty()) return fields_stem;
  std::string safe = grid;
  std::replace_if(
      safe.begin(), safe.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return fields_stem + "_" + safe;
}

std::vector<ResultFiles> result_files(const ReportSpec& report, const std::string& title) {
  std::vector<ResultFiles> out;
  for (std::size_t i = 0; i < report.tables.size(); ++i)
    out.push_back({report.tables[i].origin, table_file(report, i, title), true});
  for (std::size_t i = 0; i < report.fields.size(); ++i) {
    const std::string stem = fields_stem(report, i, title);
    out.push_back(
        {report.fields[i].origin, stem + ".pvd", false, series_of(report.fields[i], stem)});
  }
  for (std::size_t i = 0; i < report.pictures.size(); ++i)
    if (report.pictures[i].in_row > 0)
      out.push_back({report.pictures[i].origin, picture_file(report, i, title)});
  for (std::size_t i = 0; i < report.lines.size(); ++i)
    out.push_back({report.lines[i].origin, line_file(report, i, title), true});
  for (std::size_t i = 0; i < report.plots.size(); ++i)
    out.push_back({report.plots[i].origin, plot_file(report, i, title)});
  for (std::size_t i = 0; i < report.graphs.size(); ++i)
    out.push_back({report.graphs[i].origin, graphs_file(report, i, title)});
  return out;
}

bool in_series(const std::string& file, const std::string& stem) {
  return (file.ends_with(".vtu") || file.ends_with(".pvtu")) && file.starts_with(stem + "_");
}

std::string shared_file(const ResultFiles& a, const ResultFiles& b) {
  if (a.file == b.file) return a.file;
  for (const std::string& stem : b.series)
    if (in_series(a.file, stem)) return a.file;
  for (const std::string& stem : a.series) {
    if (in_series(b.file, stem)) return b.file;
    if (std::ranges::find(b.series, stem) != b.series.end()) return stem + "_00001.vtu";
  }
  return {};
}

} // namespace hvi::solver
