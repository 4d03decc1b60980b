// Pictures by gnuplot: triangles sorted from back to front, each filled with its colour.
#include "lang/pictures.hpp"

#include "lang/gnuplot.hpp"
#include "solver/output/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>

namespace hvi::lang {

namespace {

using solver::Point;
using Triangle = std::array<std::int32_t, 3>;

struct Face {
  double depth;
  std::array<std::array<double, 2>, 3> corners;
  double value;
};

/// What is seen: the cells in 2D, the boundary in 3D.
std::vector<Triangle> surface(const solver::Mesh& mesh) {
  std::vector<Triangle> out;
  if (mesh.dim == 2)
    for (const auto& cell : mesh.cells) out.push_back({cell[0], cell[1], cell[2]});
  if (mesh.dim == 3)
    for (const solver::Facet& facet : mesh.facets)
      if (facet.other < 0) out.push_back({facet.nodes[0], facet.nodes[1], facet.nodes[2]});
  return out;
}

/// Screen coordinates and depth: the plane itself in 2D, a view from the front right above in 3D.
std::array<double, 3> project(const Point& p, int dim) {
  if (dim == 2) return {p[0], p[1], 0.0};
  const double turn = 0.6, tilt = 0.45; // radians
  const double x = std::cos(turn) * p[0] + std::sin(turn) * p[2];
  const double away = -std::sin(turn) * p[0] + std::cos(turn) * p[2];
  return {x, std::cos(tilt) * p[1] - std::sin(tilt) * away,
          std::sin(tilt) * p[1] + std::cos(tilt) * away};
}

/// At every node: a scalar, or the norm of a vector or tensor.
std::vector<double> magnitudes(const solver::PictureValues& shown, std::size_t components) {
  std::vector<double> out(shown.values.size() / components);
  for (std::size_t i = 0; i < out.size(); ++i) {
    double sum = 0.0;
    for (std::size_t c = 0; c < components; ++c) {
      const double value = shown.values[i * components + c];
      sum += value * value;
    }
    out[i] = components == 1 ? shown.values[i] : std::sqrt(sum);
  }
  return out;
}

/// The places of the mesh's nodes, moved by so many times the displacement.
std::vector<Point> places(const solver::Space& space, const solver::Vector& u, double times) {
  std::vector<Point> out = space.mesh->nodes;
  for (std::size_t i = 0; times != 0.0 && i < out.size(); ++i)
    for (int c = 0; c < space.mesh->dim; ++c)
      out[i][static_cast<std::size_t>(c)] += times * u[space.dof(static_cast<int>(i), c)];
  return out;
}

/// Facets are ordered counterclockwise seen from outside: those that turn away are hidden.
bool faces_us(const Face& d) {
  const auto& [a, b, c] = d.corners;
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
}

/// A little larger about its centre, so that no seam lets what lies behind shine through.
void widen(Face& d) {
  for (int axis = 0; axis < 2; ++axis) {
    const double centre = (d.corners[0][axis] + d.corners[1][axis] + d.corners[2][axis]) / 3.0;
    for (auto& corner : d.corners) corner[axis] = centre + 1.02 * (corner[axis] - centre);
  }
}

std::string polygons(const solver::Mesh& mesh, const std::vector<Point>& at,
                     const std::vector<double>& values) {
  std::vector<Face> drawn;
  for (const Triangle& t : surface(mesh)) {
    Face one{0.0, {}, 0.0};
    for (int k = 0; k < 3; ++k) {
      const auto p = project(at[static_cast<std::size_t>(t[k])], mesh.dim);
      one.corners[k] = {p[0], p[1]};
      one.depth += p[2];
      one.value += values[t[k]] / 3.0;
    }
    if (mesh.dim == 3) {
      if (!faces_us(one)) continue;
      widen(one);
    }
    drawn.push_back(one);
  }
  std::stable_sort(drawn.begin(), drawn.end(),
                   [](const Face& a, const Face& b) { return a.depth < b.depth; });
  std::string out;
  for (const Face& one : drawn) {
    for (const auto& corner : one.corners)
      fmt::format_to(std::back_inserter(out), "{:.8g} {:.8g} {:.8g}\n", corner[0], corner[1],
                     one.value);
    out += "\n";
  }
  return out;
}

/// A body so slender that labels along its short side would lie on each other has three of them,
/// and its colour box lies below it.
std::string layout(const solver::Mesh& mesh) {
  if (mesh.dim == 3) return "unset border\nunset xtics\nunset ytics\n";
  const solver::Box box = solver::bounding_box(mesh);
  const double wide = box.high[0] - box.low[0], tall = box.high[1] - box.low[1];
  constexpr double slender = 4.0;
  if (wide > slender * tall)
    return fmt::format(
        "set ytics {:.6g}\nset colorbox horizontal user origin 0.1,0.2 size 0.8,0.03\n", tall / 2);
  if (tall > slender * wide) return fmt::format("set xtics {:.6g}\n", wide / 2);
  return {};
}

/// The commands of one picture.
std::string commands_for(const solver::PictureSpec& picture, const solver::Discretisation& d,
                         const solver::PictureValues& shown) {
  const auto values = magnitudes(shown, picture.field.components.size());
  const std::string label =
      (picture.field.components.size() > 1 ? fmt::format("|{}|", picture.field.name)
                                           : picture.field.name) +
      (picture.time ? fmt::format(", t = {:g}", *picture.time) : "") +
      (picture.deformed != 0.0 ? fmt::format(", deformed {:g} times", picture.deformed) : "");
  return fmt::format("set size ratio -1\nunset key\n{}"
                     "set palette defined (0 '#30123b', 1 '#28bbec', 2 '#a2fc3c', 3 '#fb8022', 4 "
                     "'#7a0403')\nset title {} noenhanced\n$data << HVI_END\n{}HVI_END\n"
                     "plot $data using 1:2:3 with filledcurves closed fc palette {}notitle\n",
                     layout(d.mesh), quoted(label),
                     polygons(d.mesh, places(d.space, shown.u, picture.deformed), values),
                     // borders are drawn after all areas: those of hidden ones would be seen
                     d.mesh.dim == 3 ? "fs solid noborder " : "");
}

} // namespace

std::string picture_file(const solver::Problem& problem, const solver::PictureSpec& picture) {
  if (!picture.file.empty()) return picture.file;
  return fmt::format("{}_{}{}{}.png", problem.title, picture.field.name,
                     picture.deformed != 0.0 ? "_deformed" : "",
                     picture.time ? fmt::format("_t{:g}", *picture.time) : "");
}

std::string plot_file(const solver::Plan& plan, std::size_t i) {
  const std::string& given = plan.report.plots[i].file;
  if (!given.empty()) return given;
  return plan.problem.title + (i == 0 ? "_plot.svg" : fmt::format("_plot{}.svg", i + 1));
}

namespace {

/// A column of the run's tables, or its times.
const std::vector<double>& column(const solver::RunResult& result, const std::string& name) {
  const auto found = result.columns.find(name);
  return found == result.columns.end() ? result.times : found->second;
}

/// Curves over one column; rows without a value are left out.
std::string commands_for(const solver::PlotSpec& spec, const solver::RunResult& result) {
  const auto& over = column(result, spec.against);
  std::string data, curves;
  for (std::size_t c = 0; c < spec.columns.size(); ++c) {
    const auto& values = column(result, spec.columns[c]);
    fmt::format_to(std::back_inserter(data), "$curve{} << HVI_END\n", c);
    for (std::size_t r = 0; r < values.size(); ++r)
      if (std::isfinite(over[r]) && std::isfinite(values[r]))
        fmt::format_to(std::back_inserter(data), "{:.10g} {:.10g}\n", over[r], values[r]);
    data += "HVI_END\n";
    fmt::format_to(std::back_inserter(curves),
                   "{}$curve{} using 1:2 with linespoints pt 7 ps 0.35 lw 1.5 title {} noenhanced",
                   c == 0 ? "" : ", ", c, quoted(spec.columns[c]));
  }
  const bool one = spec.columns.size() == 1;
  return fmt::format("{}set grid\n{}set xlabel {} noenhanced\n{}plot {}\n", data,
                     one ? "unset key\n" : "set key outside right top\n", quoted(spec.against),
                     one ? "set ylabel " + quoted(spec.columns[0]) + " noenhanced\n" : "", curves);
}

} // namespace

std::vector<Drawn> draw_pictures(const solver::Plan& plan, const solver::Discretisation& d,
                                 const solver::RunResult& result, const std::string& folder) {
  std::vector<Drawn> out;
  const auto draw = [&](solver::Origin origin, const std::string& file, bool named,
                        const auto& commands, Canvas canvas) {
    out.push_back({origin, file, {}, named});
    try {
      plot(commands(), std::filesystem::path(folder) / file, canvas);
    } catch (const solver::Failure& failure) {
      out.back().failure = failure;
    }
  };
  for (std::size_t i = 0; i < plan.report.pictures.size(); ++i) {
    const auto& picture = plan.report.pictures[i];
    if (d.mesh.dim == 1) continue;
    draw(picture.origin, picture_file(plan.problem, picture), !picture.file.empty(),
         [&] { return commands_for(picture, d, result.pictures.at(i)); }, {});
  }
  for (std::size_t i = 0; i < plan.report.plots.size(); ++i) {
    const auto& spec = plan.report.plots[i];
    draw(spec.origin, plot_file(plan, i), !spec.file.empty(),
         [&] { return commands_for(spec, result); }, {.white = true});
  }
  return out;
}

} // namespace hvi::lang
