// Meshes shared by the tests of fem and assembly.
#pragma once

#include "solver/fem/region.hpp"
#include "solver/mesh/generate.hpp"

#include <cmath>
#include <numeric>
#include <random>

namespace hvi::solver::test {

inline Mesh box_mesh(int dim, std::array<int, 3> cells, std::array<double, 3> high = {1, 1, 1}) {
  std::array<std::vector<double>, 3> lines;
  for (int a = 0; a < dim; ++a) lines[a] = uniform_coordinates(0, high[a], cells[a]);
  return structured_mesh(dim, lines);
}

/// A box under a linear map and with its inner nodes shaken: no cell like another, no side along an
/// axis, every side still plane.
inline Mesh skew_mesh(int dim, int cells, unsigned seed = 7) {
  Mesh mesh = box_mesh(dim, {cells, cells, cells});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-0.12 / cells, 0.12 / cells);
  for (auto& p : mesh.nodes) {
    bool inner = true;
    for (int a = 0; a < dim; ++a) inner = inner && p[a] > 1e-9 && p[a] < 1 - 1e-9;
    for (int a = 0; a < dim && inner; ++a) p[a] += shake(random);
    p = {1.3 * p[0] + 0.4 * p[1] + 0.2 * p[2], dim > 1 ? 0.9 * p[1] + 0.3 * p[2] - 0.2 * p[0] : 0,
         dim > 2 ? 1.1 * p[2] + 0.15 * p[0] : 0};
  }
  return mesh;
}

/// Length, area or volume of its entities; of points their number.
inline double measure_of(const Mesh& mesh, const Region& region) {
  double sum = 0;
  for (const auto e : region.entities) {
    if (region.kind == Group::Kind::cells) sum += cell_measure(mesh, e);
    if (region.kind == Group::Kind::facets) sum += facet_measure(mesh, e);
  }
  return region.kind == Group::Kind::points ? static_cast<double>(region.entities.size()) : sum;
}

inline Region all_cells(const Mesh& mesh) {
  Region region;
  region.kind = Group::Kind::cells;
  region.entities.resize(mesh.cells.size());
  std::iota(region.entities.begin(), region.entities.end(), 0);
  return region;
}

/// All facets of the boundary.
inline Region skin(const Mesh& mesh) {
  Region region;
  region.kind = Group::Kind::facets;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    if (mesh.facets[f].other < 0) region.entities.push_back(static_cast<std::int32_t>(f));
  }
  return region;
}

inline Region group(const Mesh& mesh, const std::string& name) {
  const Group& g = mesh.groups.at(name);
  return {g.kind, g.entities, 0};
}

inline Region join(const Region& a, const Region& b) {
  Region out = a;
  out.entities.insert(out.entities.end(), b.entities.begin(), b.entities.end());
  std::sort(out.entities.begin(), out.entities.end());
  return out;
}

inline Region node_region(const Mesh& mesh, const Point& p) {
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const Point& q = mesh.nodes[i];
    if (std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]) < 1e-9) {
      return {Group::Kind::points, {static_cast<std::int32_t>(i)}, 0};
    }
  }
  throw std::invalid_argument("no node there");
}

inline const Expr x = Expr::variable(slot::x(0)), y = Expr::variable(slot::x(1)),
                  z = Expr::variable(slot::x(2)), t = Expr::variable(slot::t);

} // namespace hvi::solver::test
