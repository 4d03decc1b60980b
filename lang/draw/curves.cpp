// See curves.hpp.
#include "lang/draw/curves.hpp"

#include "lang/draw/axes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::lang::draw {
namespace {

/// M. Okabe, K. Ito, Color universal design (2008): told apart by everybody.
constexpr Colour line_colours[] = {{0.0, 0.447, 0.698}, {0.835, 0.369, 0.0}, {0.0, 0.62, 0.451},
                                   {0.8, 0.475, 0.655}, {0.902, 0.624, 0.0}, {0.337, 0.706, 0.914},
                                   {0.0, 0.0, 0.0}};

constexpr double dot_size = 6.0;

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void include(double x) {
    if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
  }
  /// With air around it.
  Range wider(double part) const {
    if (!(low <= high)) return {0.0, 1.0};
    const double size = high - low;
    const double air = size > 0.0 ? part * size : low == 0.0 ? 1.0 : 0.5 * std::abs(low);
    return {low - air, high + air};
  }
};

void add_legend(Sheet& sheet, const CurvePlot& plot, Spot at) {
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    if (plot.curves[i].name.empty()) continue;
    sheet.line({at, {at[0] + 22.0, at[1]}}, line_colours[i % std::size(line_colours)], 2.2);
    sheet.words({{at[0] + 28.0, at[1] + 4.0}, plot.curves[i].name, 12.0});
    at[1] += 18.0;
  }
}

/// A line, or a dot where its points are one: that is no line.
void add_line(Sheet& sheet, const std::vector<Spot>& line, const Colour& colour) {
  if (line.empty()) return;
  const auto at_first = [&](const Spot& p) {
    return std::hypot(p[0] - line[0][0], p[1] - line[0][1]) < dot_size;
  };
  if (!std::ranges::all_of(line, at_first)) return sheet.line(line, colour, 2.0);
  const double left = line[0][0] - 0.5 * dot_size, top = line[0][1] - 0.5 * dot_size;
  const double right = left + dot_size, bottom = top + dot_size;
  sheet.marks.emplace_back(
      Fill{{{left, top}, {right, top}, {right, bottom}, {left, bottom}}, colour});
}

/// One plot into a box of a sheet.
void add_plot(Sheet& sheet, const CurvePlot& plot, Spot corner, double width, double height) {
  Range x, y;
  for (const Curve& curve : plot.curves)
    for (const Spot& p : curve.points) x.include(p[0]), y.include(p[1]);
  if (plot.y_range) y = {(*plot.y_range)[0], (*plot.y_range)[1]};
  x = x.wider(0.0), y = y.wider(0.05);
  if (!(x.high > x.low)) x.high = x.low + 1.0;
  const Plane plane{corner[0] + 84.0,
                    corner[1] + 44.0,
                    width - 108.0,
                    height - 100.0,
                    x.low,
                    x.high,
                    y.low,
                    y.high};
  sheet.words({{plane.left, corner[1] + 26.0}, plot.title, 15.0});
  add_axes(sheet, plane, plot.x_name, plot.y_name, true);
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    std::vector<Spot> line;
    const auto draw = [&] {
      add_line(sheet, line, line_colours[i % std::size(line_colours)]);
      line.clear();
    };
    for (const Spot& p : plot.curves[i].points)
      std::isfinite(p[0]) && std::isfinite(p[1]) ? line.push_back(plane(p[0], p[1])) : draw();
    draw();
  }
  add_legend(sheet, plot, {plane.left + 14.0, plane.top + 14.0});
}

} // namespace

Sheet curves_sheet(const CurvePlot& plot) { return panels_sheet({plot}); }

Sheet panels_sheet(const std::vector<CurvePlot>& plots) {
  const bool one = plots.size() == 1;
  const double width = one ? 720.0 : 480.0, height = one ? 460.0 : 360.0;
  const int columns = one ? 1 : 2;
  Sheet sheet;
  const auto rows = (static_cast<int>(plots.size()) + columns - 1) / columns;
  sheet.width = columns * width;
  sheet.height = rows * height;
  for (int i = 0; i < static_cast<int>(plots.size()); ++i)
    add_plot(sheet, plots[static_cast<std::size_t>(i)],
             {width * (i % columns), height * (i / columns)}, width, height);
  return sheet;
}

} // namespace hvi::lang::draw
