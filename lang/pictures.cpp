// Pictures of a run: frames (solver/output) and columns of tables drawn by lang/draw.
#include "lang/pictures.hpp"

#include "lang/draw/body.hpp"
#include "lang/draw/curves.hpp"
#include "lang/draw/paint.hpp"
#include "lang/law_curves.hpp"
#include "solver/plan/result_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <span>

namespace hvi::lang {

namespace {

constexpr int frame_milliseconds = 100; ///< of pictures that move

constexpr std::size_t longest_title = 60, longest_label = 15; ///< letters of a field

/// A field as the script writes it, on one line; one with a comment by its name, of a long one the
/// beginning.
std::string words_of(const Script& script, const solver::FieldSpec& field) {
  std::string out;
  for (const char c : script.sources.text(span_of(script, field.origin)))
    if (std::isspace(static_cast<unsigned char>(c)) == 0)
      out += c;
    else if (!out.empty() && out.back() != ' ')
      out += ' ';
  if (out.empty() || out.find('#') != std::string::npos) out = field.name;
  if (out.size() <= longest_title) return out;
  std::size_t end = longest_title - 3;
  while (end > 0 && (static_cast<unsigned char>(out[end]) & 0xC0u) == 0x80u) --end; // whole letters
  return out.substr(0, end) + "...";
}

draw::BodyPicture picture_of(const Script& script, const solver::PictureSpec& spec,
                             std::optional<double> time) {
  const solver::ReportSpec& report = script.plan->report;
  draw::BodyPicture out;
  out.field = spec.field.name;
  const std::string words = words_of(script, spec.field),
                    unit_of_field = ModelUnits::bracketed(spec.field.unit);
  const std::string shown = spec.field.components.size() > 1 ? fmt::format("|{}|", words) : words;
  out.title = shown + unit_of_field;
  out.label = shown.size() <= longest_label ? out.title : spec.field.unit;
  const std::string& unit = report.unit_of_time;
  if (time) out.title += fmt::format(", t = {:g}{}{}", *time, unit.empty() ? "" : " ", unit);
  if (spec.deformed != 0.0) out.title += fmt::format(", deformed {:g} times", spec.deformed);
  out.deformed = spec.deformed;
  out.unit_of_length = ModelUnits::bracketed(report.unit_of_length);
  return out;
}

/// One picture, or one that moves: its frames are in one window and have the same colours.
void write_picture(const Script& script, const solver::PictureSpec& spec,
                   const std::vector<solver::FieldFrame>& frames,
                   const std::filesystem::path& path) {
  if (!solver::moves(spec))
    return draw::write_sheet(draw::body_sheet(frames.front(), picture_of(script, spec, spec.time)),
                             path);
  const auto window = draw::window_of(frames, picture_of(script, spec, {}));
  const auto sheet = [&](std::size_t i) {
    return draw::body_sheet(frames[i], picture_of(script, spec, frames[i].t), window);
  };
  draw::write_sheets(frames.size(), sheet, frame_milliseconds, path);
}

/// Pictures side by side. Those of one field are in one window and have the same colours.
void write_row(const Script& script, std::span<const solver::PictureSpec> specs,
               std::span<const std::vector<solver::FieldFrame>> frames,
               const std::filesystem::path& path) {
  std::vector<draw::Sheet> sheets;
  for (std::size_t i = 0; i < specs.size(); ++i) {
    std::vector<solver::FieldFrame> of_field;
    for (std::size_t j = 0; j < specs.size(); ++j)
      if (specs[j].field.name == specs[i].field.name) of_field.push_back(frames[j].front());
    draw::BodyPicture picture = picture_of(script, specs[i], specs[i].time);
    picture.widest = 400.0, picture.highest = 300.0;
    sheets.push_back(
        draw::body_sheet(frames[i].front(), picture, draw::window_of(of_field, picture)));
  }
  draw::write_sheet(draw::sheets_in_rows(sheets), path);
}

/// A column of the run's tables, or its times.
const std::vector<double>& column(const solver::RunResult& result, const std::string& name) {
  const auto found = result.columns.find(name);
  return found == result.columns.end() ? result.times : found->second;
}

/// Curves over one column; rows without a value are left out.
draw::CurvePlot plot_of(const solver::PlotSpec& spec, const solver::RunResult& result,
                        const ModelUnits& units) {
  const auto& over = column(result, spec.against);
  draw::CurvePlot out;
  out.x_name = spec.against + units.behind(spec.against);
  const bool one = spec.columns.size() == 1;
  if (one) out.y_name = spec.columns.front() + units.behind(spec.columns.front());
  for (const std::string& name : spec.columns) {
    const auto& values = column(result, name);
    draw::Curve curve;
    if (!one) curve.name = name + units.behind(name);
    for (std::size_t r = 0; r < values.size(); ++r)
      if (std::isfinite(over[r]) && std::isfinite(values[r]))
        curve.points.push_back({over[r], values[r]});
    out.curves.push_back(std::move(curve));
  }
  return out;
}

/// The set-valued graph of a law or the graph of a kernel, as a panel. Throws Failure(bad_law) for
/// a law that is known only together with a solution.
draw::CurvePlot panel_of(const solver::GraphSpec& graph, const solver::TimeSpec& time,
                         const ModelUnits& units, solver::Origin origin) {
  const double t0 = time.grid.empty() ? 0.0 : time.grid.front();
  const double t = time.grid.empty() ? 0.0 : time.grid.back();
  draw::CurvePlot out;
  out.title = graph.name;
  draw::Curve curve;
  if (const auto* law = std::get_if<solver::LawSpec>(&graph.of)) {
    curve.points = law_curve(*law, t);
    if (!law->coupled.empty())
      out.title += fmt::format(", for the multiplier 1 of {}", law->coupled);
    out.x_name = (law->radial ? "|z|" : "z") + units.of_argument(graph.name);
    out.y_name = (law->radial ? "|\u03be|" : "\u03be") + units.of_multiplier(graph.name);
    if (curve.points.empty())
      throw solver::Failure(solver::FailureKind::bad_law, origin,
                            fmt::format("the law `{}` has no graph of its own: it depends on what "
                                        "it reads of the solution",
                                        graph.name));
  } else {
    const auto& kernel = std::get<solver::KernelSpec>(graph.of);
    curve.points = kernel_curve(kernel, t0, t);
    out.x_name = "t \u2212 s" + units.behind("t");
    const bool itself = kernel.name == graph.name;
    if (!kernel.name.empty() && !itself)
      out.title += " = q " + kernel.name + units.of_kernel(graph.name);
    out.y_name = itself ? "q" + units.of_kernel(graph.name) : "q, the factor of time";
  }
  out.curves.push_back(std::move(curve));
  return out;
}

draw::Sheet sheet_of(const solver::GraphsSpec& spec, const solver::TimeSpec& time,
                     const ModelUnits& units) {
  std::vector<draw::CurvePlot> panels;
  for (const auto& graph : spec.graphs) panels.push_back(panel_of(graph, time, units, spec.origin));
  return draw::panels_sheet(panels);
}

} // namespace

std::vector<Drawn> draw_pictures(const Script& script, const solver::RunResult& result,
                                 const solver::Shown& shown, const std::string& folder) {
  const solver::Plan& plan = *script.plan;
  const std::string& title = plan.problem.title;
  const ModelUnits& units = script.model->units;
  std::vector<Drawn> out;
  const auto add = [&](solver::Origin origin, const std::string& file, bool named,
                       const auto& write) {
    out.push_back({origin, file, {}, named});
    try {
      write(std::filesystem::path(folder) / file);
    } catch (const solver::Failure& failure) {
      out.back().failure = failure;
    }
  };
  for (std::size_t i = 0; i < shown.pictures.size(); ++i) {
    const auto& picture = plan.report.pictures[i];
    const auto& frames = shown.pictures[i];
    const auto n = static_cast<std::size_t>(std::max(picture.in_row, 0));
    if (n > 0)
      add(picture.origin, solver::picture_file(plan.report, i, title), !picture.file.empty(),
          [&](const auto& path) {
            if (n == 1) return write_picture(script, picture, frames, path);
            write_row(script, std::span(plan.report.pictures).subspan(i, n),
                      std::span(shown.pictures).subspan(i, n), path);
          });
  }
  for (std::size_t i = 0; i < plan.report.plots.size(); ++i) {
    const auto& spec = plan.report.plots[i];
    add(spec.origin, solver::plot_file(plan.report, i, title), !spec.file.empty(),
        [&](const auto& path) {
          draw::write_sheet(draw::curves_sheet(plot_of(spec, result, units)), path);
        });
  }
  for (std::size_t i = 0; i < plan.report.graphs.size(); ++i) {
    const auto& spec = plan.report.graphs[i];
    add(spec.origin, solver::graphs_file(plan.report, i, title), !spec.file.empty(),
        [&](const auto& path) {
          draw::write_sheet(sheet_of(spec, plan.problem.time, units), path);
        });
  }
  return out;
}

} // namespace hvi::lang
