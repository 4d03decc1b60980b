// See mesh_sight.hpp.
#include "lang/mesh_sight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace hvi::lang {

namespace {

/// Okabe and Ito's, as far as they go: black names can be read on all of them.
constexpr std::array<draw::Colour, 8> colours{{{0.0, 0.447, 0.698},
                                               {0.835, 0.369, 0.0},
                                               {0.0, 0.62, 0.451},
                                               {0.8, 0.475, 0.655},
                                               {0.902, 0.624, 0.0},
                                               {0.337, 0.706, 0.914},
                                               {0.941, 0.894, 0.259},
                                               {0.69, 0.58, 0.85}}};
constexpr draw::Colour edges_in_space{0.45, 0.45, 0.45};
constexpr double fine = 2.0; ///< pixels of the image to one of the sheet

draw::Triangle triangle_of(std::span<const std::int32_t> nodes) {
  return {nodes[0], nodes[1], nodes[2]};
}

draw::Point normal_of(const solver::Mesh& mesh, const draw::Triangle& t) {
  const auto node = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(t[k])]; };
  return draw::cross(draw::minus(node(1), node(0)), draw::minus(node(2), node(0)));
}

/// What a part colours: its first and, of a pair, its second side.
template <class Colouring>
void colour_parts(const solver::Discretisation& d, solver::Group::Kind kind,
                  const Colouring& colour) {
  for (std::size_t p = 0; p < d.parts.size(); ++p) {
    if (d.parts[p].kind != kind || is_whole(d, p)) continue; // the body itself stays grey
    for (const auto e : d.parts[p].entities) colour(static_cast<std::size_t>(e), colour_of(p));
    for (const auto e : d.parts[p].second) colour(static_cast<std::size_t>(e), colour_of(p));
  }
}

draw::Frame frame_of(const draw::Plane& plane, double pixels) {
  const double scale = pixels * plane.width / (plane.x_high - plane.x_low);
  return {plane.x_low, plane.y_low, scale, static_cast<int>(std::ceil(pixels * plane.width)),
          static_cast<int>(std::ceil(pixels * plane.height))};
}

/// An entity's number as a colour, one byte after the other.
draw::Colour coded(std::int32_t entity) {
  const auto byte = [&](int shift) { return ((entity + 1) >> shift & 255) / 255.0; };
  return {byte(16), byte(8), byte(0)};
}

void draw_one(draw::Raster& raster, const solver::Mesh& mesh, const Patch& patch,
              draw::Colour colour) {
  const draw::Point normal = normal_of(mesh, patch.nodes);
  raster.surface({patch.nodes}, mesh.nodes, {{normal, normal, normal}}, colour);
}

} // namespace

Place flat(const solver::Point& p, int dim) {
  const draw::Point seen = draw::view_of(dim)(p);
  return {seen[0], seen[1]};
}

ViewBox view_box(const solver::Mesh& mesh) {
  ViewBox out;
  for (const auto& node : mesh.nodes) {
    const Place p = flat(node, mesh.dim);
    for (std::size_t a = 0; a < 2; ++a)
      out.low[a] = std::min(out.low[a], p[a]), out.high[a] = std::max(out.high[a], p[a]);
  }
  if (mesh.dim > 1) return out;
  const double room = 0.05 * out.size(); // a line has no height
  out.low[1] -= room, out.high[1] += room;
  return out;
}

bool is_whole(const solver::Discretisation& d, std::size_t part) {
  return d.parts[part].kind == solver::Group::Kind::cells &&
         d.parts[part].entities.size() == d.mesh.cells.size();
}

draw::Colour colour_of(std::size_t part) { return colours.at(part % colours.size()); }

std::vector<Patch> patches(const solver::Discretisation& d) {
  const solver::Mesh& mesh = d.mesh;
  std::vector<Patch> out;
  std::vector<draw::Colour> of_cell(mesh.cells.size(), plain);
  colour_parts(d, solver::Group::Kind::cells,
               [&](std::size_t c, draw::Colour colour) { of_cell[c] = colour; });
  if (mesh.dim == 2)
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
      out.push_back({triangle_of(mesh.cells[c]), static_cast<std::int32_t>(c), of_cell[c]});
  if (mesh.dim < 3) return out;
  std::vector<draw::Colour> of_facet;
  for (const auto& facet : mesh.facets)
    of_facet.push_back(of_cell[static_cast<std::size_t>(facet.cell)]);
  colour_parts(d, solver::Group::Kind::facets,
               [&](std::size_t f, draw::Colour colour) { of_facet[f] = colour; });
  const draw::Point toward = draw::view_of(3).toward;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const draw::Triangle nodes = triangle_of(mesh.facets[f].nodes);
    if (mesh.facets[f].other < 0 && draw::dot(normal_of(mesh, nodes), toward) > 0.0)
      out.push_back({nodes, static_cast<std::int32_t>(f), of_facet[f]});
  }
  return out;
}

MeshSight::MeshSight(const solver::Mesh& mesh, const std::vector<Patch>& all,
                     const draw::Plane& plane)
    : raster_(draw::view_of(mesh.dim), frame_of(plane, 1.0), false) {
  for (const Patch& patch : all) draw_one(raster_, mesh, patch, coded(patch.entity));
}

std::int32_t MeshSight::in_front(const Place& at) const {
  const auto [red, green, blue, drawn] = raster_.sample(at[0], at[1]);
  return drawn > 0 ? (red << 16 | green << 8 | blue) - 1 : -1;
}

draw::Panel patches_panel(const solver::Mesh& mesh, const std::vector<Patch>& all,
                          const draw::Plane& plane, bool with_edges) {
  draw::Raster raster(draw::view_of(mesh.dim), frame_of(plane, fine), mesh.dim == 3);
  for (const Patch& patch : all) draw_one(raster, mesh, patch, patch.colour);
  if (with_edges)
    for (const Patch& patch : all)
      for (std::size_t k = 0; k < 3; ++k)
        raster.line(mesh.nodes[static_cast<std::size_t>(patch.nodes[k])],
                    mesh.nodes[static_cast<std::size_t>(patch.nodes[(k + 1) % 3])], edges_in_space,
                    0.4 * fine);
  const draw::Image image = raster.image();
  return {{plane.left, plane.top}, image.width / fine, image.height / fine, image};
}

} // namespace hvi::lang
