// See mesh_picture.hpp. By gnuplot: polygons from back to front, lines and dots over them.
#include "lang/mesh_picture.hpp"

#include "lang/gnuplot.hpp"
#include "solver/fem/region.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <vector>

namespace hvi::lang {

namespace {

using Colour = const char*;
using Place = std::array<double, 2>;

constexpr Colour plain = "#e4e4e4", edges = "#9a9a9a";
constexpr std::array<Colour, 8> colours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                           "#e69f00", "#56b4e9", "#7a0403", "#6a3d9a"};
/// Beyond this the edges of cells would cover everything.
constexpr std::size_t most_edges = 20'000;

Colour colour_of(std::size_t part) { return colours.at(part % colours.size()); }

/// A triangle of the picture.
struct Patch {
  double depth = 0.0;
  std::array<Place, 3> corners{};
  Colour colour = plain;
};

/// The plane itself in 2D; in 3D from the front, right and above. Last: how near.
std::array<double, 3> seen(const solver::Point& p, int dim) {
  if (dim == 2) return {p[0], p[1], 0.0};
  constexpr double turn = 0.6, tilt = 0.45; // radians
  const double across = std::cos(turn) * p[0] + std::sin(turn) * p[2];
  const double away = -std::sin(turn) * p[0] + std::cos(turn) * p[2];
  return {across, std::cos(tilt) * p[1] - std::sin(tilt) * away,
          std::sin(tilt) * p[1] + std::cos(tilt) * away};
}

Patch patch_of(const solver::Mesh& mesh, std::span<const std::int32_t> nodes, Colour colour) {
  Patch out;
  out.colour = colour;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto p = seen(mesh.nodes[static_cast<std::size_t>(nodes[k])], mesh.dim);
    out.corners[k] = {p[0], p[1]};
    out.depth += p[2];
  }
  return out;
}

/// Counterclockwise: in 3D its outer side is seen.
bool looks_at_us(const Patch& patch) {
  const auto& [a, b, c] = patch.corners;
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
}

/// What a part colours: its first and, of a pair, its second side.
template <class Colouring>
void colour_parts(const solver::Discretisation& d, solver::Group::Kind kind,
                  const Colouring& colour) {
  for (std::size_t p = 0; p < d.parts.size(); ++p) {
    if (d.parts[p].kind != kind) continue;
    for (const auto e : d.parts[p].entities) colour(e, p);
    for (const auto e : d.parts[p].second) colour(e, p);
  }
}

std::vector<Patch> patches(const solver::Discretisation& d) {
  const solver::Mesh& mesh = d.mesh;
  std::vector<Patch> out;
  if (mesh.dim == 2) {
    std::vector<Colour> of_cell(mesh.cells.size(), plain);
    colour_parts(d, solver::Group::Kind::cells,
                 [&](std::int32_t c, std::size_t p) { of_cell[c] = colour_of(p); });
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      out.push_back(patch_of(mesh, std::span(mesh.cells[c]).first(3), of_cell[c]));
    return out;
  }
  std::vector<Colour> of_facet(mesh.facets.size(), plain);
  std::vector<Colour> of_cell(mesh.cells.size(), plain);
  colour_parts(d, solver::Group::Kind::cells,
               [&](std::int32_t c, std::size_t p) { of_cell[c] = colour_of(p); });
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) of_facet[f] = of_cell[mesh.facets[f].cell];
  colour_parts(d, solver::Group::Kind::facets,
               [&](std::int32_t f, std::size_t p) { of_facet[f] = colour_of(p); });
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    if (mesh.facets[f].other >= 0) continue;
    const Patch one = patch_of(mesh, mesh.facets[f].nodes, of_facet[f]);
    if (looks_at_us(one)) out.push_back(one);
  }
  std::ranges::stable_sort(out, {}, &Patch::depth);
  return out;
}

/// Lines of a part in 2D, dots of points.
std::string marks(const solver::Discretisation& d, std::size_t part) {
  const solver::Mesh& mesh = d.mesh;
  std::string out;
  const auto put = [&](std::int32_t node) {
    const auto p = seen(mesh.nodes[static_cast<std::size_t>(node)], mesh.dim);
    fmt::format_to(std::back_inserter(out), "{:.8g} {:.8g}\n", p[0], p[1]);
  };
  const solver::Region& region = d.parts[part];
  for (const auto* side : {&region.entities, &region.second})
    for (const auto e : *side) {
      if (region.kind == solver::Group::Kind::points) put(e);
      if (region.kind == solver::Group::Kind::facets && mesh.dim == 2) {
        put(mesh.facets[static_cast<std::size_t>(e)].nodes[0]);
        put(mesh.facets[static_cast<std::size_t>(e)].nodes[1]);
        out += "\n";
      }
    }
  return out;
}

std::string polygons_of(const std::vector<Patch>& all, Place& low, Place& high) {
  std::string out;
  low = {1e300, 1e300}, high = {-1e300, -1e300};
  const bool with_edges = all.size() <= most_edges;
  for (std::size_t i = 0; i < all.size(); ++i) {
    fmt::format_to(std::back_inserter(out), "set object {} polygon ", i + 1);
    for (const std::size_t k : {0, 1, 2, 0}) {
      const Place& at = all[i].corners[k];
      for (std::size_t a = 0; a < 2; ++a)
        low[a] = std::min(low[a], at[a]), high[a] = std::max(high[a], at[a]);
      fmt::format_to(std::back_inserter(out), "{} {:.8g},{:.8g} ",
                     k == 0 && out.ends_with("polygon ") ? "from" : "to", at[0], at[1]);
    }
    fmt::format_to(std::back_inserter(out),
                   "fc rgb '{0}' fs solid 1.0 border lc rgb '{1}' lw 0.4\n", all[i].colour,
                   with_edges ? edges : all[i].colour);
  }
  return out;
}

} // namespace

std::string describe_parts(const Script& script, const solver::Discretisation& d) {
  std::string out = "parts\n";
  for (std::size_t p = 0; p < d.parts.size(); ++p) {
    const solver::Region& region = d.parts[p];
    const bool points = region.kind == solver::Group::Kind::points;
    const bool cells = region.kind == solver::Group::Kind::cells;
    std::string what = fmt::format("{:>8} {}", region.entities.size(),
                                   points  ? "points"
                                   : cells ? "cells "
                                           : "facets");
    if (const int dim = d.mesh.dim - (cells ? 0 : 1); !points && dim > 0) {
      double measure = 0.0;
      for (const auto e : region.entities)
        measure += cells ? solver::cell_measure(d.mesh, e) : solver::facet_measure(d.mesh, e);
      what +=
          fmt::format("  {} {:.6g}", std::array{"", "length", "area", "volume"}.at(dim), measure);
    }
    if (region.is_pair()) what += fmt::format(", the other side {} facets", region.second.size());
    out += fmt::format("  {:<20} {}\n", script.plan->problem.parts[p].name, what);
  }
  return out;
}

void draw_mesh(const Script& script, const solver::Discretisation& d,
               const std::filesystem::path& picture) {
  if (d.mesh.dim == 1)
    throw solver::Failure(solver::FailureKind::bad_value, {}, "a mesh in 1D has no picture");
  Place low{}, high{};
  const std::string body = polygons_of(patches(d), low, high);
  const double margin = 0.04 * std::max(high[0] - low[0], high[1] - low[1]);
  std::string data, curves;
  for (std::size_t p = 0; p < d.parts.size(); ++p) {
    const std::string name = quoted(script.plan->problem.parts[p].name);
    const bool points = d.parts[p].kind == solver::Group::Kind::points;
    const std::string shown = marks(d, p);
    if (!shown.empty()) data += fmt::format("$part{} << HVI_END\n{}HVI_END\n", p, shown);
    curves += fmt::format("{}{} with {} lc rgb '{}' title {} noenhanced", p == 0 ? "" : ", ",
                          shown.empty() ? "NaN" : fmt::format("$part{} using 1:2", p),
                          points ? "points pt 7 ps 1.4" : "lines lw 4", colour_of(p), name);
  }
  plot(fmt::format("{}set size ratio -1\n{}set key outside right top\nset xrange [{:.8g}:{:.8g}]\n"
                   "set yrange [{:.8g}:{:.8g}]\n{}plot {}\n",
                   data, d.mesh.dim == 3 ? "unset border\nunset xtics\nunset ytics\n" : "",
                   low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin, body,
                   curves.empty() ? "NaN notitle" : curves),
       picture);
}

} // namespace hvi::lang
