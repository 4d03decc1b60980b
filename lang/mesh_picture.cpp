// See mesh_picture.hpp: triangles from back to front, lines and dots over them, a name beside each
// part.
#include "lang/mesh_picture.hpp"

#include "lang/draw/axes.hpp"
#include "lang/draw/paint.hpp"
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

using Place = draw::Spot;

constexpr draw::Colour plain{0.894, 0.894, 0.894}, edges{0.604, 0.604, 0.604};
/// Okabe and Ito's, as far as they go.
constexpr std::array<draw::Colour, 8> colours{{{0.0, 0.447, 0.698},
                                               {0.835, 0.369, 0.0},
                                               {0.0, 0.62, 0.451},
                                               {0.8, 0.475, 0.655},
                                               {0.902, 0.624, 0.0},
                                               {0.337, 0.706, 0.914},
                                               {0.478, 0.016, 0.012},
                                               {0.416, 0.239, 0.604}}};
/// Beyond this the edges of cells would cover everything.
constexpr std::size_t most_edges = 20'000;
constexpr double arrow = 26.0, text_size = 13.0; ///< of normals, of names

draw::Colour colour_of(std::size_t part) { return colours.at(part % colours.size()); }

/// A triangle of the picture.
struct Patch {
  double depth = 0.0;
  std::array<Place, 3> corners{};
  draw::Colour colour = plain;
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

Patch patch_of(const solver::Mesh& mesh, std::span<const std::int32_t> nodes, draw::Colour colour) {
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

bool is_whole(const solver::Discretisation& d, std::size_t part) {
  return d.parts[part].kind == solver::Group::Kind::cells &&
         d.parts[part].entities.size() == d.mesh.cells.size();
}

/// What a part colours: its first and, of a pair, its second side.
template <class Colouring>
void colour_parts(const solver::Discretisation& d, solver::Group::Kind kind,
                  const Colouring& colour) {
  for (std::size_t p = 0; p < d.parts.size(); ++p) {
    if (d.parts[p].kind != kind || is_whole(d, p)) continue; // the body itself stays grey
    for (const auto e : d.parts[p].entities) colour(e, p);
    for (const auto e : d.parts[p].second) colour(e, p);
  }
}

std::vector<Patch> patches(const solver::Discretisation& d) {
  const solver::Mesh& mesh = d.mesh;
  std::vector<Patch> out;
  if (mesh.dim == 2) {
    std::vector<draw::Colour> of_cell(mesh.cells.size(), plain);
    colour_parts(d, solver::Group::Kind::cells,
                 [&](std::int32_t c, std::size_t p) { of_cell[c] = colour_of(p); });
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      out.push_back(patch_of(mesh, std::span(mesh.cells[c]).first(3), of_cell[c]));
    return out;
  }
  std::vector<draw::Colour> of_facet(mesh.facets.size(), plain);
  std::vector<draw::Colour> of_cell(mesh.cells.size(), plain);
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

/// Where a part is named: a point of it in the plane of the picture, and the direction outward.
struct Tag {
  Place at{}, outward{};
};

Place flat(const solver::Point& p, int dim) {
  const auto at = seen(p, dim);
  return {at[0], at[1]};
}

solver::Point middle_of(const solver::Mesh& mesh, std::span<const std::int32_t> nodes) {
  solver::Point out{};
  for (const auto n : nodes)
    for (std::size_t a = 0; a < 3; ++a)
      out[a] += mesh.nodes[static_cast<std::size_t>(n)][a] / static_cast<double>(nodes.size());
  return out;
}

std::span<const std::int32_t> nodes_of(const solver::Mesh& mesh, solver::Group::Kind kind,
                                       const std::int32_t& e) {
  const auto i = static_cast<std::size_t>(e);
  const auto dim = static_cast<std::size_t>(mesh.dim);
  if (kind == solver::Group::Kind::cells) return std::span(mesh.cells[i]).first(dim + 1);
  if (kind == solver::Group::Kind::facets) return std::span(mesh.facets[i].nodes).first(dim);
  return {&e, 1};
}

solver::Point minus(const solver::Point& a, const solver::Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// The outward normal of a facet in the plane of the picture; of length 1 in space.
Place outward_of(const solver::Mesh& mesh, std::int32_t facet) {
  const auto& f = mesh.facets[static_cast<std::size_t>(facet)];
  const auto n = static_cast<std::size_t>(mesh.dim);
  const auto node = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(f.nodes[k])]; };
  const solver::Point e = minus(node(1), node(0));
  const solver::Point g = n == 3 ? minus(node(2), node(0)) : solver::Point{0.0, 0.0, 1.0};
  solver::Point normal{e[1] * g[2] - e[2] * g[1], e[2] * g[0] - e[0] * g[2],
                       e[0] * g[1] - e[1] * g[0]};
  const auto& cell = mesh.cells[static_cast<std::size_t>(f.cell)];
  const solver::Point away = minus(middle_of(mesh, std::span(f.nodes).first(n)),
                                   middle_of(mesh, std::span(cell).first(n + 1)));
  const double side = normal[0] * away[0] + normal[1] * away[1] + normal[2] * away[2];
  const double length = std::hypot(normal[0], normal[1], normal[2]) * (side < 0.0 ? -1.0 : 1.0);
  for (double& x : normal) x /= length;
  return flat(normal, mesh.dim);
}

/// Is the outer side of a facet of a body in space turned to us?
bool is_seen(const solver::Mesh& mesh, std::int32_t facet) {
  return mesh.dim == 2 ||
         looks_at_us(patch_of(mesh, mesh.facets[static_cast<std::size_t>(facet)].nodes, plain));
}

/// The box of a mesh in the plane of the picture.
struct Frame {
  Place low{1e300, 1e300}, high{-1e300, -1e300};

  double size() const { return std::max(high[0] - low[0], high[1] - low[1]); }
};

Frame frame_of(const solver::Mesh& mesh) {
  Frame out;
  for (const auto& node : mesh.nodes) {
    const Place p = flat(node, mesh.dim);
    for (std::size_t a = 0; a < 2; ++a)
      out.low[a] = std::min(out.low[a], p[a]), out.high[a] = std::max(out.high[a], p[a]);
  }
  return out;
}

/// Of a point: away from the middle of the body.
Place away_from_body(const Frame& frame, const Place& at) {
  const Place away{at[0] - 0.5 * (frame.low[0] + frame.high[0]),
                   at[1] - 0.5 * (frame.low[1] + frame.high[1])};
  const double length = std::hypot(away[0], away[1]);
  return length > 1e-3 * frame.size() ? Place{away[0] / length, away[1] / length} : Place{0.0, 1.0};
}

/// At the entity nearest to the middle of the part, of those that are seen; none: none is. Away
/// from names that stand already, and in space where the normal is not seen from its tip, if there
/// is such a place.
std::optional<Tag> tag_of(const solver::Mesh& mesh, const solver::Region& region,
                          const Frame& frame, std::span<const std::optional<Tag>> others) {
  constexpr double long_enough = 0.5, apart = 0.25; // of the normal, of the box
  const bool facets = region.kind == solver::Group::Kind::facets;
  std::vector<Tag> shown;
  for (const auto e : region.entities) {
    if (facets && !is_seen(mesh, e)) continue;
    const Place at = flat(middle_of(mesh, nodes_of(mesh, region.kind, e)), mesh.dim);
    const bool point = region.kind == solver::Group::Kind::points;
    shown.push_back({at, facets  ? outward_of(mesh, e)
                         : point ? away_from_body(frame, at)
                                 : Place{}});
  }
  if (shown.empty()) return std::nullopt;
  Place middle{};
  for (const Tag& tag : shown)
    for (std::size_t a = 0; a < 2; ++a) middle[a] += tag.at[a] / static_cast<double>(shown.size());
  const auto distance = [](const Place& a, const Place& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1]);
  };
  const auto cost = [&](const Tag& tag) {
    const bool crowded = std::ranges::any_of(others, [&](const std::optional<Tag>& other) {
      return other && distance(other->at, tag.at) < apart * frame.size();
    });
    const bool short_arrow = facets && std::hypot(tag.outward[0], tag.outward[1]) < long_enough;
    return distance(tag.at, middle) + (crowded ? 10.0 : 0.0) * frame.size() +
           (short_arrow ? 100.0 : 0.0) * frame.size();
  };
  return *std::ranges::min_element(shown, {}, cost);
}

/// By part; points first, since they have no other place.
std::vector<std::optional<Tag>> tags_of(const solver::Discretisation& d, const Frame& frame) {
  std::vector<std::optional<Tag>> out(d.parts.size());
  for (const bool points : {true, false})
    for (std::size_t p = 0; p < d.parts.size(); ++p)
      if (points == (d.parts[p].kind == solver::Group::Kind::points))
        out[p] =
            tag_of(d.mesh, d.parts[p], frame, points ? std::span(out).first(0) : std::span(out));
  return out;
}

void add_arrow(draw::Sheet& sheet, Place from, Place along, draw::Colour colour) {
  const Place tip{from[0] + along[0] * arrow, from[1] + along[1] * arrow};
  constexpr double head = 7.0;
  const Place across{-along[1], along[0]};
  const auto barb = [&](double side) {
    return Place{tip[0] - head * along[0] + side * 0.5 * head * across[0],
                 tip[1] - head * along[1] + side * 0.5 * head * across[1]};
  };
  sheet.line({from, tip}, colour, 1.6);
  sheet.line({barb(1.0), tip, barb(-1.0)}, colour, 1.6);
}

/// The name of a part with the arrow of its normal, of a point with a line to it; sheets have y
/// downward.
void add_tag(draw::Sheet& sheet, const draw::Plane& plane, const Tag& tag, bool is_point,
             const std::string& name, draw::Colour colour) {
  const Place at = plane(tag.at[0], tag.at[1]);
  const Place along{tag.outward[0], -tag.outward[1]};
  const bool has_line = along[0] != 0.0 || along[1] != 0.0;
  if (is_point)
    sheet.line({at, {at[0] + along[0] * arrow, at[1] + along[1] * arrow}}, draw::grey);
  else if (has_line)
    add_arrow(sheet, at, along, colour);
  const double reach = has_line ? arrow + 8.0 : 0.0;
  const double anchor = along[0] > 0.4 ? 0.0 : along[0] < -0.4 ? 1.0 : 0.5;
  const double lower = along[1] > 0.4 ? 10.0 : along[1] < -0.4 ? 0.0 : 4.0;
  sheet.words({{at[0] + reach * along[0], at[1] + reach * along[1] + lower},
               name,
               text_size,
               anchor,
               draw::black});
}

/// Lines of a part in 2D, dots of points.
void add_marks(draw::Sheet& sheet, const draw::Plane& plane, const solver::Discretisation& d,
               std::size_t part) {
  const solver::Mesh& mesh = d.mesh;
  const solver::Region& region = d.parts[part];
  const auto at = [&](std::int32_t node) {
    const Place p = flat(mesh.nodes[static_cast<std::size_t>(node)], mesh.dim);
    return plane(p[0], p[1]);
  };
  for (const auto* side : {&region.entities, &region.second})
    for (const auto e : *side) {
      if (region.kind == solver::Group::Kind::facets && mesh.dim == 2) {
        const auto& nodes = mesh.facets[static_cast<std::size_t>(e)].nodes;
        sheet.line({at(nodes[0]), at(nodes[1])}, colour_of(part), 3.0);
      }
      if (region.kind != solver::Group::Kind::points) continue;
      const Place c = at(e);
      draw::Fill dot{{}, colour_of(part)};
      for (int k = 0; k < 16; ++k)
        dot.outline.push_back({c[0] + 4.5 * std::cos(k * std::numbers::pi / 8),
                               c[1] + 4.5 * std::sin(k * std::numbers::pi / 8)});
      sheet.marks.emplace_back(std::move(dot));
    }
}

/// The box in the middle of a sheet with room for names.
draw::Plane plane_of(const Frame& frame, double width, double height) {
  constexpr double room = 90.0;
  const auto& [low, high] = frame;
  const double scale = std::min((width - 2.0 * room) / (high[0] - low[0]),
                                (height - 2.0 * room) / (high[1] - low[1]));
  const double w = scale * (high[0] - low[0]), h = scale * (high[1] - low[1]);
  return {0.5 * (width - w), 0.5 * (height - h), w, h, low[0], high[0], low[1], high[1]};
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
    sheet.words({{corner[0] + along[0] * (arrow + 9.0), corner[1] + along[1] * (arrow + 9.0) + 4.0},
                 std::string(1, "xyz"[a]),
                 text_size,
                 0.5,
                 draw::grey});
  }
}

/// All parts by their colours; those that nothing of is seen say so.
void add_key(draw::Sheet& sheet, const Script& script, const solver::Discretisation& d,
             std::span<const std::optional<Tag>> tags) {
  Place at{sheet.width - 170.0, 30.0};
  for (std::size_t p = 0; p < d.parts.size(); ++p, at[1] += 18.0) {
    sheet.line({at, {at[0] + 20.0, at[1]}}, is_whole(d, p) ? plain : colour_of(p), 4.0);
    sheet.words({{at[0] + 28.0, at[1] + 4.0},
                 script.plan->problem.parts[p].name + (tags[p] ? "" : " (behind)"),
                 12.0});
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
  if (d.mesh.dim == 1)
    throw solver::Failure(solver::FailureKind::bad_value, {}, "a mesh in 1D has no picture");
  draw::Sheet sheet;
  const Frame frame = frame_of(d.mesh);
  const draw::Plane plane = plane_of(frame, sheet.width - 170.0, sheet.height);
  const auto all = patches(d);
  for (const Patch& patch : all) {
    std::vector<Place> outline;
    for (const Place& corner : patch.corners) outline.push_back(plane(corner[0], corner[1]));
    outline.push_back(outline.front());
    sheet.marks.emplace_back(draw::Fill{outline, patch.colour});
    if (all.size() <= most_edges) sheet.line(std::move(outline), edges, 0.4);
  }
  for (std::size_t p = 0; p < d.parts.size(); ++p) add_marks(sheet, plane, d, p);
  const auto tags = tags_of(d, frame);
  for (std::size_t p = 0; p < d.parts.size(); ++p) {
    if (!tags[p] || is_whole(d, p)) continue;
    add_tag(sheet, plane, *tags[p], d.parts[p].kind == solver::Group::Kind::points,
            script.plan->problem.parts[p].name, d.mesh.dim == 3 ? draw::black : colour_of(p));
  }
  add_triad(sheet, d.mesh.dim);
  add_key(sheet, script, d, tags);
  draw::write_sheet(sheet, picture);
}

} // namespace hvi::lang
