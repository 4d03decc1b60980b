// See mesh_picture.hpp: what is seen of the cells, lines and dots over it, a name beside each part.
#include "lang/mesh_picture.hpp"

#include "lang/draw/axes.hpp"
#include "lang/draw/paint.hpp"
#include "lang/mesh_sight.hpp"
#include "lang/mesh_tags.hpp"
#include "solver/fem/region.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace hvi::lang {

namespace {

constexpr draw::Colour edges{0.604, 0.604, 0.604};
/// Beyond this the edges of cells would cover everything.
constexpr std::size_t most_edges = 20'000;

void add_arrow(draw::Sheet& sheet, Place from, Place along, draw::Colour colour) {
  const Place tip{from[0] + along[0] * tag_arrow, from[1] + along[1] * tag_arrow};
  constexpr double head = 7.0;
  const Place across{-along[1], along[0]};
  const auto barb = [&](double side) {
    return Place{tip[0] - head * along[0] + side * 0.5 * head * across[0],
                 tip[1] - head * along[1] + side * 0.5 * head * across[1]};
  };
  sheet.line({from, tip}, colour, 1.6);
  sheet.line({barb(1.0), tip, barb(-1.0)}, colour, 1.6);
}

/// The name of a part with what leads to it; sheets have y downward.
void add_tag(draw::Sheet& sheet, const draw::Plane& plane, const Tag& tag, const std::string& name,
             draw::Colour colour) {
  const Place at = plane(tag.at[0], tag.at[1]);
  const Place along{tag.outward[0], -tag.outward[1]};
  if (tag.kind == Tag::Kind::line)
    sheet.line({at, {at[0] + along[0] * tag_arrow, at[1] + along[1] * tag_arrow}}, draw::grey);
  else if (tag.kind == Tag::Kind::normal)
    add_arrow(sheet, at, along, colour);
  const double reach = tag.kind == Tag::Kind::none ? 0.0 : tag_arrow + 8.0;
  const double anchor = along[0] > 0.4 ? 0.0 : along[0] < -0.4 ? 1.0 : 0.5;
  const double lower = along[1] > 0.4 ? 10.0 : along[1] < -0.4 ? 0.0 : 4.0;
  sheet.words({{at[0] + reach * along[0], at[1] + reach * along[1] + lower},
               name,
               tag_size,
               anchor,
               draw::black});
}

/// Lines of a part in 2D, dots of points and of the ends of an interval.
void add_marks(draw::Sheet& sheet, const draw::Plane& plane, const solver::Discretisation& d,
               std::size_t part) {
  const solver::Mesh& mesh = d.mesh;
  const solver::Region& region = d.parts[part];
  const bool facets = region.kind == solver::Group::Kind::facets;
  const auto at = [&](std::int32_t node) {
    const Place p = flat(mesh.nodes[static_cast<std::size_t>(node)], mesh.dim);
    return plane(p[0], p[1]);
  };
  const auto dot = [&](std::int32_t node) {
    const Place c = at(node);
    draw::Fill out{{}, colour_of(part)};
    for (int k = 0; k < 16; ++k)
      out.outline.push_back({c[0] + 4.5 * std::cos(k * std::numbers::pi / 8),
                             c[1] + 4.5 * std::sin(k * std::numbers::pi / 8)});
    sheet.marks.emplace_back(std::move(out));
  };
  for (const auto* side : {&region.entities, &region.second})
    for (const auto e : *side) {
      if (region.kind == solver::Group::Kind::points) dot(e);
      if (!facets || mesh.dim == 3) continue;
      const auto& nodes = mesh.facets[static_cast<std::size_t>(e)].nodes;
      if (mesh.dim == 1)
        dot(nodes[0]);
      else
        sheet.line({at(nodes[0]), at(nodes[1])}, colour_of(part), 3.0);
    }
}

/// The box in the middle of a sheet with room for names.
draw::Plane plane_of(const ViewBox& box, double width, double height) {
  constexpr double room = 90.0;
  const auto& [low, high] = box;
  const double scale = std::min((width - 2.0 * room) / (high[0] - low[0]),
                                (height - 2.0 * room) / (high[1] - low[1]));
  const double w = scale * (high[0] - low[0]), h = scale * (high[1] - low[1]);
  return {0.5 * (width - w), 0.5 * (height - h), w, h, low[0], high[0], low[1], high[1]};
}

/// Triangles of the plane, each for itself: whoever opens the SVG finds the mesh in it.
void add_triangles(draw::Sheet& sheet, const draw::Plane& plane, const solver::Mesh& mesh,
                   const std::vector<Patch>& all) {
  for (const Patch& patch : all) {
    std::vector<Place> outline;
    for (const auto node : patch.nodes) {
      const solver::Point& p = mesh.nodes[static_cast<std::size_t>(node)];
      outline.push_back(plane(p[0], p[1]));
    }
    outline.push_back(outline.front());
    sheet.marks.emplace_back(draw::Fill{outline, patch.colour});
    if (all.size() <= most_edges) sheet.line(std::move(outline), edges, 0.4);
  }
}

/// An interval: its cells between ticks, each in the colour of its part.
void add_segments(draw::Sheet& sheet, const draw::Plane& plane, const solver::Discretisation& d) {
  const auto place = [&](std::int32_t node) {
    return plane(d.mesh.nodes[static_cast<std::size_t>(node)][0], 0.0);
  };
  const auto segment = [&](std::int32_t c, draw::Colour colour) {
    const auto& nodes = d.mesh.cells[static_cast<std::size_t>(c)];
    sheet.line({place(nodes[0]), place(nodes[1])}, colour, 6.0);
  };
  for (std::size_t c = 0; c < d.mesh.cells.size(); ++c)
    segment(static_cast<std::int32_t>(c), plain);
  for (std::size_t p = 0; p < d.parts.size(); ++p)
    if (d.parts[p].kind == solver::Group::Kind::cells && !is_whole(d, p))
      for (const auto c : d.parts[p].entities) segment(c, colour_of(p));
  constexpr std::size_t most_ticks = 400;
  for (std::size_t i = 0; d.mesh.nodes.size() <= most_ticks && i < d.mesh.nodes.size(); ++i) {
    const Place p = place(static_cast<std::int32_t>(i));
    sheet.line({{p[0], p[1] - 6.0}, {p[0], p[1] + 6.0}}, edges, 0.8);
  }
}

/// The axes of space, below at the left.
void add_triad(draw::Sheet& sheet, int dim) {
  const Place corner{46.0, sheet.height - 36.0};
  for (int a = 0; a < dim; ++a) {
    solver::Point unit{};
    unit[static_cast<std::size_t>(a)] = 1.0;
    const Place p = flat(unit, dim);
    const Place along{p[0], -p[1]};
    add_arrow(sheet, corner, along, draw::grey);
    sheet.words(
        {{corner[0] + along[0] * (tag_arrow + 9.0), corner[1] + along[1] * (tag_arrow + 9.0) + 4.0},
         std::string(1, "xyz"[a]),
         tag_size,
         0.5,
         draw::grey});
  }
}

/// All parts by their colours; those that nothing of is seen say so.
void add_key(draw::Sheet& sheet, const solver::Discretisation& d,
             std::span<const std::string> names, std::span<const std::optional<Tag>> tags) {
  Place at{sheet.width - 170.0, 30.0};
  for (std::size_t p = 0; p < d.parts.size(); ++p, at[1] += 18.0) {
    sheet.line({at, {at[0] + 20.0, at[1]}}, is_whole(d, p) ? plain : colour_of(p), 4.0);
    sheet.words({{at[0] + 28.0, at[1] + 4.0}, names[p] + (tags[p] ? "" : " (behind)"), 12.0});
  }
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
  draw::Sheet sheet;
  const draw::Plane plane = plane_of(view_box(d.mesh), sheet.width - 170.0, sheet.height);
  const auto all = patches(d);
  if (d.mesh.dim == 1)
    add_segments(sheet, plane, d);
  else if (d.mesh.dim == 2)
    add_triangles(sheet, plane, d.mesh, all);
  else
    sheet.marks.emplace_back(patches_panel(d.mesh, all, plane, all.size() <= most_edges));
  for (std::size_t p = 0; p < d.parts.size(); ++p) add_marks(sheet, plane, d, p);
  std::vector<std::string> names;
  for (const auto& part : script.plan->problem.parts) names.push_back(part.name);
  const MeshSight sight(d.mesh, all, plane);
  const auto tags = tags_of(d, names, sight, plane);
  for (std::size_t p = 0; p < d.parts.size(); ++p)
    if (tags[p] && !is_whole(d, p))
      add_tag(sheet, plane, *tags[p], names[p], d.mesh.dim == 3 ? draw::black : colour_of(p));
  add_triad(sheet, d.mesh.dim);
  add_key(sheet, d, names, tags);
  draw::write_sheet(sheet, picture);
}

} // namespace hvi::lang
