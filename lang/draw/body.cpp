// See body.hpp.
#include "lang/draw/body.hpp"

#include "lang/draw/axes.hpp"
#include "lang/draw/curves.hpp"
#include "lang/draw/raster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hvi::lang::draw {
namespace {

using solver::FieldFrame;
using solver::norm;
using solver::VtuGrid;

constexpr double fine = 2.0; ///< pixels of the panel to one of the sheet
constexpr Colour edge_colour{0.13, 0.13, 0.15}, rest_colour{0.6, 0.6, 0.62};
constexpr double longest_arrow = 0.16; ///< of the body's size
constexpr double visible_arrow = 0.02; ///< of the longest: shorter ones are left out

const VtuGrid& body_of(const FieldFrame& frame) { return frame.grids.front().grid; }

std::vector<Point> moved(const VtuGrid& grid, double factor) {
  std::vector<Point> out = grid.points;
  const auto by = nodal_vectors(grid, solver::displacement_array);
  for (std::size_t i = 0; i < by.size(); ++i)
    for (int k = 0; k < 3; ++k) out[i][k] += factor * by[i][k];
  return out;
}

double diagonal_of(const std::vector<Point>& points) {
  Point low = points.front(), high = low;
  for (const Point& p : points)
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

/// The grids of the contact that hold the field, and the forces at the points of laws.
struct OnContact {
  std::vector<const VtuGrid*> fields;
  std::vector<Point> points, forces;
};

OnContact contact_of(const FieldFrame& frame, const BodyPicture& picture) {
  OnContact out;
  for (std::size_t g = 1; g < frame.grids.size(); ++g) {
    const VtuGrid& grid = frame.grids[g].grid;
    if (!numbers_of(grid, picture.field).values.empty()) out.fields.push_back(&grid);
    const auto forces = nodal_vectors(grid, solver::force_array);
    if (forces.empty()) continue;
    const auto points = moved(grid, picture.deformed);
    out.points.insert(out.points.end(), points.begin(), points.end());
    out.forces.insert(out.forces.end(), forces.begin(), forces.end());
  }
  return out;
}

/// Everything that is drawn, before it is known where on the sheet.
struct Scene {
  int dim = 2;
  std::vector<Point> points;
  std::vector<Point> at_rest; ///< where the body was; empty: where it is
  Skin skin;
  Numbers numbers; ///< of the body; none: it has one colour
  OnContact contact;
  std::vector<Arrow> arrows;
  std::vector<double> arrow_values;
};

/// The largest force has the longest arrow.
void add_arrows(Scene& scene, double size, double largest) {
  if (!(largest > 0.0)) return;
  for (std::size_t i = 0; i < scene.contact.forces.size(); ++i) {
    const Point& f = scene.contact.forces[i];
    if (norm(f) < visible_arrow * largest) continue;
    const Point& tip = scene.contact.points[i];
    Point tail = tip;
    for (int k = 0; k < 3; ++k) tail[k] -= longest_arrow * size * f[k] / largest;
    scene.arrows.push_back(arrow(tail, tip, 0.006 * size));
    scene.arrow_values.push_back(norm(f));
  }
}

Scene scene_of(const FieldFrame& frame, const BodyPicture& picture, const ColourMap& colours) {
  Scene out;
  const VtuGrid& body = body_of(frame);
  out.points = moved(body, picture.deformed);
  if (picture.deformed != 0.0) out.at_rest = body.points;
  out.skin = skin_of(body);
  out.dim = out.skin.dim;
  out.numbers = numbers_of(body, picture.field);
  if (!out.numbers.values.empty()) return out;
  out.contact = contact_of(frame, picture);
  add_arrows(out, diagonal_of(body.points), colours.high());
  return out;
}

void include(BodyWindow& out, const Scene& scene, const View& view) {
  const auto add = [&](const std::vector<Point>& points) {
    for (const Point& p : points) {
      const Point seen = view(p);
      out.left = std::min(out.left, seen[0]), out.right = std::max(out.right, seen[0]);
      out.bottom = std::min(out.bottom, seen[1]), out.top = std::max(out.top, seen[1]);
    }
  };
  add(scene.points), add(scene.at_rest);
  for (const Arrow& a : scene.arrows) add(a.points);
}

void draw_edges(Raster& raster, const std::vector<Edge>& edges, const std::vector<Point>& points,
                Colour colour, double thick) {
  for (const auto& [a, b] : edges) raster.line(points[a], points[b], colour, thick);
}

/// Every edge of a mesh whose cells are large enough on the picture.
void draw_mesh(Raster& raster, const Scene& scene, double pixels_to_a_unit) {
  double shortest = std::numeric_limits<double>::infinity();
  const auto length = [&](int a, int b) {
    const Point &p = scene.points[a], &q = scene.points[b];
    return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
  };
  for (const Triangle& t : scene.skin.triangles)
    for (int k = 0; k < 3; ++k) shortest = std::min(shortest, length(t[k], t[(k + 1) % 3]));
  constexpr double visible = 9.0; // pixels of the sheet
  if (shortest * pixels_to_a_unit < visible * fine) return;
  for (const Triangle& t : scene.skin.triangles)
    for (int k = 0; k < 3; ++k)
      if (t[k] < t[(k + 1) % 3])
        raster.line(scene.points[t[k]], scene.points[t[(k + 1) % 3]], edge_colour, 0.7, 0.22);
}

void draw_contact(Raster& raster, const Scene& scene, const BodyPicture& picture,
                  const ColourMap& colours) {
  for (std::size_t a = 0; a < scene.arrows.size(); ++a) {
    const Arrow& one = scene.arrows[a];
    const Skin skin{3, one.triangles, {}};
    raster.surface(one.triangles, one.points, corner_normals(skin, one.points),
                   colours(scene.arrow_values[a]));
  }
  if (!scene.contact.forces.empty()) return;
  for (const VtuGrid* grid : scene.contact.fields) {
    const Numbers numbers = numbers_of(*grid, picture.field);
    const Skin skin = skin_of(*grid);
    if (!skin.triangles.empty())
      raster.surface(skin.triangles, grid->points, corner_normals(skin, grid->points),
                     corner_numbers(skin, numbers), colours);
    const auto stride = static_cast<std::size_t>(nodes_of(grid->cell));
    for (std::size_t c = 0; skin.dim < 2 && c + stride <= grid->connectivity.size(); c += stride) {
      const auto a = grid->connectivity[c], b = grid->connectivity[c + (stride > 1 ? 1 : 0)];
      const auto& v = numbers.values;
      raster.line(grid->points[a], grid->points[b],
                  colours(numbers.of_cells ? v[c / stride] : 0.5 * (v[a] + v[b])), 5.0 * fine);
    }
  }
}

Image drawn(const BodyPicture& picture, const Scene& scene, const View& view, const Frame& window,
            const ColourMap& colours) {
  Raster raster(view, window, scene.dim == 3);
  const auto normals = corner_normals(scene.skin, scene.points);
  if (scene.numbers.values.empty())
    raster.surface(scene.skin.triangles, scene.points, normals, plain);
  else
    raster.surface(scene.skin.triangles, scene.points, normals,
                   corner_numbers(scene.skin, scene.numbers), colours);
  const auto edges = feature_edges(scene.skin, scene.points);
  draw_mesh(raster, scene, window.scale);
  draw_contact(raster, scene, picture, colours);
  draw_edges(raster, edges, scene.points, edge_colour, 1.1 * fine);
  if (!scene.at_rest.empty())
    draw_edges(raster, feature_edges(scene.skin, scene.at_rest), scene.at_rest, rest_colour,
               0.6 * fine);
  return raster.image();
}

/// The directions of the axes, in a corner.
void add_triad(Sheet& sheet, const View& view, Spot at) {
  constexpr const char* names[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    Point unit{};
    unit[k] = 34.0;
    const Point seen = view(unit);
    const Spot tip{at[0] + seen[0], at[1] - seen[1]};
    sheet.line({at, tip}, black, 1.2);
    const double size = std::hypot(seen[0], seen[1]);
    const double past = size > 8.0 ? 10.0 / size : 0.0;
    sheet.words({{tip[0] + past * seen[0], tip[1] - past * seen[1] + 4.0}, names[k], 12.0, 0.5});
  }
}

/// Values of one grid that the colours stand for.
void add_values(std::vector<double>& out, const FieldFrame& frame, const std::string& field) {
  const auto add = [&](double value) {
    if (!std::isnan(value)) out.push_back(value);
  };
  const auto body = numbers_of(body_of(frame), field).values;
  std::ranges::for_each(body, add);
  if (!body.empty()) return;
  const std::size_t before = out.size();
  for (std::size_t g = 1; g < frame.grids.size(); ++g)
    for (const Point& f : nodal_vectors(frame.grids[g].grid, solver::force_array)) add(norm(f));
  if (out.size() != before) return;
  for (std::size_t g = 1; g < frame.grids.size(); ++g)
    std::ranges::for_each(numbers_of(frame.grids[g].grid, field).values, add);
}

/// A 1D body: the field over it, constant in each cell where it is one of cells.
Sheet curve_sheet(const FieldFrame& frame, const BodyPicture& picture, const BodyWindow& window) {
  const VtuGrid& body = body_of(frame);
  const Numbers numbers = numbers_of(body, picture.field);
  Curve curve;
  if (numbers.of_cells) {
    const auto stride = static_cast<std::size_t>(nodes_of(body.cell));
    std::vector<std::array<double, 3>> cells; // begin, end, value
    for (std::size_t c = 0; c < numbers.values.size(); ++c) {
      if (std::isnan(numbers.values[c])) continue;
      const double a = body.points[body.connectivity[c * stride]][0],
                   b = body.points[body.connectivity[c * stride + 1]][0];
      cells.push_back({std::min(a, b), std::max(a, b), numbers.values[c]});
    }
    std::ranges::sort(cells);
    for (const auto& [begin, end, value] : cells) {
      curve.points.push_back({begin, value});
      curve.points.push_back({end, value});
    }
  } else {
    for (std::size_t i = 0; i < numbers.values.size(); ++i)
      curve.points.push_back({body.points[i][0], numbers.values[i]});
    std::ranges::sort(curve.points);
  }
  CurvePlot plot;
  plot.title = picture.title;
  plot.x_name = "x" + picture.unit_of_length;
  plot.y_name = picture.label;
  plot.y_range = {window.least, window.most};
  plot.curves.push_back(std::move(curve));
  return curves_sheet(plot);
}

/// A scene on a sheet of which the bounds fill the panel.
Sheet scene_sheet(const Scene& scene, const BodyPicture& picture, const View& view,
                  const BodyWindow& bounds, const ColourMap& colours) {
  const bool flat = scene.dim == 2;
  const double left = flat ? 78.0 : 24.0, top = 56.0, below = flat ? 52.0 : 24.0, beside = 130.0;
  constexpr double least_high = 90.0;
  const double wide = bounds.right - bounds.left, high = bounds.top - bounds.bottom;
  const double scale = std::min(picture.widest / wide, picture.highest / high);
  Sheet sheet;
  constexpr double rounding = 1e-6; // of a pixel: the side that fills its space is a whole number
  const double panel_wide = std::ceil(scale * wide - rounding) + 4.0,
               panel_high = std::ceil(scale * high - rounding) + 4.0;
  const double box_high = std::max(panel_high, least_high);
  sheet.width = std::max(left + panel_wide + 28.0 + beside, 360.0);
  sheet.height = top + box_high + below;
  const double panel_top = top + 0.5 * (box_high - panel_high);
  const Frame window{bounds.left - 2.0 / scale, bounds.bottom - 2.0 / scale, fine * scale,
                     static_cast<int>(fine * panel_wide), static_cast<int>(fine * panel_high)};
  sheet.marks.emplace_back(Panel{
      {left, panel_top}, panel_wide, panel_high, drawn(picture, scene, view, window, colours)});
  if (flat) {
    const double shown_wide = panel_wide / scale, shown_high = panel_high / scale;
    add_axes(sheet,
             {left - 8.0, panel_top, panel_wide + 8.0, panel_high + 8.0, window.left - 8.0 / scale,
              window.left + shown_wide, window.bottom - 8.0 / scale, window.bottom + shown_high},
             "x" + picture.unit_of_length, "y" + picture.unit_of_length, false);
  } else {
    add_triad(sheet, view, {46.0, sheet.height - 40.0});
  }
  sheet.words({{left, 26.0}, picture.title, 15.0});
  const Spot below_bar{sheet.width - beside + 10.0, sheet.height - 14.0};
  constexpr double range_above = 15.0; // the last line, and below half of the bar's lowest number
  const double room = below_bar[1] - range_above - 21.0 - (top + 14.0);
  add_bar(sheet, colours, below_bar[0], top + 14.0, std::min({box_high - 14.0, room, 320.0}),
          picture.label);
  const std::string range = number_text(colours.low()) + " to " + number_text(colours.high());
  constexpr std::size_t most_letters = 19; // of the size 11 that stand below the bar
  const bool fits = range.size() <= most_letters;
  sheet.words({{fits ? below_bar[0] : sheet.width - 6.0, below_bar[1] - range_above},
               range,
               11.0,
               fits ? 0.0 : 1.0,
               grey});
  if (scene.numbers.of_cells) sheet.words({below_bar, "cell by cell", 11.0, 0.0, grey});
  return sheet;
}

} // namespace

BodyWindow window_of(std::span<const FieldFrame> frames, const BodyPicture& picture) {
  BodyWindow out;
  std::vector<double> values;
  for (const FieldFrame& frame : frames) add_values(values, frame, picture.field);
  if (!values.empty()) {
    const auto [least, most] = std::ranges::minmax(values);
    out.least = least, out.most = most;
  }
  for (const FieldFrame& frame : frames) {
    const Scene scene = scene_of(frame, picture, {out.least, out.most});
    if (scene.dim >= 2) include(out, scene, view_of(scene.dim));
  }
  return out;
}

Sheet body_sheet(const FieldFrame& frame, const BodyPicture& picture, const BodyWindow& window) {
  const ColourMap colours(window.least, window.most);
  const Scene scene = scene_of(frame, picture, colours);
  if (scene.dim < 2) return curve_sheet(frame, picture, window);
  return scene_sheet(scene, picture, view_of(scene.dim), window, colours);
}

Sheet body_sheet(const FieldFrame& frame, const BodyPicture& picture) {
  return body_sheet(frame, picture, window_of({&frame, 1}, picture));
}

} // namespace hvi::lang::draw
