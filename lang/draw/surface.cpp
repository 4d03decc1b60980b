// See surface.hpp.
#include "lang/draw/surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace hvi::lang::draw {
namespace {

using solver::VtkCell;
using solver::VtuArray;
using solver::VtuGrid;

/// A face of a cell: its corners, and its middle nodes (edges 01, 12, 20) where it is quadratic.
struct Face {
  std::int32_t cell = 0;
  std::array<std::int64_t, 6> nodes{};
  std::array<std::int64_t, 3> sorted() const {
    std::array<std::int64_t, 3> out{nodes[0], nodes[1], nodes[2]};
    std::ranges::sort(out);
    return out;
  }
};

/// Faces of VTK's tetrahedra, outward: corners, then the middles of their edges.
constexpr int tetra_faces[4][6] = {
    {0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {0, 3, 2, 7, 9, 6}};

void add_face(Skin& skin, const Face& face, bool quadratic) {
  const auto& n = face.nodes;
  const auto add = [&](int a, int b, int c) {
    skin.triangles.push_back({static_cast<std::int32_t>(n[a]), static_cast<std::int32_t>(n[b]),
                              static_cast<std::int32_t>(n[c])});
    skin.cells.push_back(face.cell);
  };
  if (!quadratic) return add(0, 1, 2);
  add(0, 3, 5), add(3, 1, 4), add(5, 4, 2), add(3, 4, 5);
}

double volume_of(const VtuGrid& grid, const std::int64_t* cell, int corners) {
  const Point& o = grid.points[cell[0]];
  if (corners == 2)
    return std::sqrt(dot(minus(grid.points[cell[1]], o), minus(grid.points[cell[1]], o)));
  const Point a = minus(grid.points[cell[1]], o), b = minus(grid.points[cell[2]], o);
  const Point n = cross(a, b);
  if (corners == 3) return std::sqrt(dot(n, n));
  return std::abs(dot(n, minus(grid.points[cell[3]], o)));
}

int corners_of(VtkCell cell) {
  switch (cell) {
  case VtkCell::vertex:
    return 1;
  case VtkCell::line:
  case VtkCell::quadratic_edge:
    return 2;
  case VtkCell::triangle:
  case VtkCell::quadratic_triangle:
    return 3;
  default:
    return 4;
  }
}

const VtuArray* array_of(const std::vector<VtuArray>& arrays, const std::string& name) {
  const auto found = std::ranges::find(arrays, name, &VtuArray::name);
  return found == arrays.end() ? nullptr : &*found;
}

double size_of(const double* values, int components) {
  if (components == 1) return values[0];
  return std::sqrt(std::inner_product(values, values + components, values, 0.0));
}

struct EdgeUse {
  std::int32_t first = -1, second = -1; ///< triangles; second < 0: one only
  bool crowded = false;                 ///< more than two
};

std::map<Edge, EdgeUse> edges_of(const Skin& skin) {
  std::map<Edge, EdgeUse> out;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      Edge edge{skin.triangles[t][k], skin.triangles[t][(k + 1) % 3]};
      if (edge[0] > edge[1]) std::swap(edge[0], edge[1]);
      EdgeUse& use = out[edge];
      const auto number = static_cast<std::int32_t>(t);
      if (use.first < 0)
        use.first = number;
      else if (use.second < 0)
        use.second = number;
      else
        use.crowded = true;
    }
  return out;
}

/// Not normalised: its length is twice the area.
Point normal_of(const Triangle& t, const std::vector<Point>& points) {
  return cross(minus(points[t[1]], points[t[0]]), minus(points[t[2]], points[t[0]]));
}

} // namespace

Skin skin_of(const VtuGrid& grid) {
  Skin out;
  const int stride = nodes_of(grid.cell), corners = corners_of(grid.cell);
  const bool quadratic = stride > corners;
  out.dim = corners - 1;
  const std::size_t cells = grid.connectivity.size() / static_cast<std::size_t>(stride);
  std::vector<Face> faces;
  for (std::size_t c = 0; c < cells; ++c) {
    const std::int64_t* const n = grid.connectivity.data() + c * stride;
    if (corners == 3) {
      Face face;
      face.cell = static_cast<std::int32_t>(c);
      std::copy_n(n, stride, face.nodes.begin());
      add_face(out, face, quadratic);
    } else if (corners == 4) {
      for (const auto& local : tetra_faces) {
        Face face;
        face.cell = static_cast<std::int32_t>(c);
        for (int k = 0; k < (quadratic ? 6 : 3); ++k) face.nodes[k] = n[local[k]];
        faces.push_back(face);
      }
    }
  }
  std::vector<std::pair<std::array<std::int64_t, 3>, std::int32_t>> keys;
  keys.reserve(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    keys.emplace_back(faces[f].sorted(), static_cast<std::int32_t>(f));
  std::ranges::sort(keys);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const bool shared = (i > 0 && keys[i - 1].first == keys[i].first) ||
                        (i + 1 < keys.size() && keys[i + 1].first == keys[i].first);
    if (!shared) add_face(out, faces[keys[i].second], quadratic);
  }
  return out;
}

std::vector<std::array<Point, 3>> corner_normals(const Skin& skin,
                                                 const std::vector<Point>& points) {
  std::vector<std::vector<std::int32_t>> around(points.size());
  std::vector<Point> normals;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    normals.push_back(normal_of(skin.triangles[t], points));
    for (const auto node : skin.triangles[t]) around[node].push_back(static_cast<std::int32_t>(t));
  }
  std::vector<std::array<Point, 3>> out(skin.triangles.size());
  for (std::size_t t = 0; t < skin.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Point own = unit(normals[t]);
      Point sum{};
      for (const auto other : around[skin.triangles[t][k]])
        if (dot(own, unit(normals[other])) > sharp)
          for (int i = 0; i < 3; ++i) sum[i] += normals[other][i];
      out[t][k] = unit(sum);
    }
  return out;
}

std::vector<Edge> feature_edges(const Skin& skin, const std::vector<Point>& points) {
  std::vector<Edge> out;
  for (const auto& [edge, use] : edges_of(skin)) {
    const bool alone = use.second < 0 || use.crowded;
    const bool bent = !alone && skin.dim == 3 &&
                      dot(unit(normal_of(skin.triangles[use.first], points)),
                          unit(normal_of(skin.triangles[use.second], points))) < sharp;
    if (alone || bent) out.push_back(edge);
  }
  return out;
}

NodalArray nodal_array(const VtuGrid& grid, const std::string& name) {
  if (const VtuArray* const a = array_of(grid.point_data, name)) return {a->components, a->values};
  const VtuArray* const a = array_of(grid.cell_data, name);
  if (a == nullptr) return {};
  const int n = a->components, stride = nodes_of(grid.cell), corners = corners_of(grid.cell);
  NodalArray out{n, std::vector<double>(grid.points.size() * n, 0.0)};
  std::vector<double> weights(grid.points.size(), 0.0);
  for (std::size_t c = 0; c * stride < grid.connectivity.size(); ++c) {
    const std::int64_t* const cell = grid.connectivity.data() + c * stride;
    if (std::isnan(a->values[c * n])) continue; // a cell without a value
    const double volume = volume_of(grid, cell, corners);
    for (int k = 0; k < stride; ++k) {
      weights[cell[k]] += volume;
      for (int i = 0; i < n; ++i) out.values[cell[k] * n + i] += volume * a->values[c * n + i];
    }
  }
  for (std::size_t p = 0; p < weights.size(); ++p)
    for (int i = 0; i < n; ++i) out.values[p * n + i] /= weights[p]; // without any: NaN
  return out;
}

Numbers numbers_of(const VtuGrid& grid, const std::string& name) {
  const VtuArray* a = array_of(grid.point_data, name);
  Numbers out;
  out.of_cells = a == nullptr;
  if (out.of_cells) a = array_of(grid.cell_data, name);
  if (a == nullptr) return {};
  for (std::size_t i = 0; i < a->values.size(); i += static_cast<std::size_t>(a->components))
    out.values.push_back(size_of(a->values.data() + i, a->components));
  return out;
}

std::vector<std::array<double, 3>> corner_numbers(const Skin& skin, const Numbers& numbers) {
  std::vector<std::array<double, 3>> out;
  out.reserve(skin.triangles.size());
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const auto& [i, j, k] = skin.triangles[t];
    if (numbers.of_cells) {
      const double value = numbers.values[skin.cells[t]];
      out.push_back({value, value, value});
    } else {
      out.push_back({numbers.values[i], numbers.values[j], numbers.values[k]});
    }
  }
  return out;
}

std::vector<Point> nodal_vectors(const VtuGrid& grid, const std::string& name) {
  const VtuArray* const a = array_of(grid.point_data, name);
  if (a == nullptr || a->components != 3) return {};
  std::vector<Point> out;
  for (std::size_t i = 0; i < grid.points.size(); ++i)
    out.push_back({a->values[3 * i], a->values[3 * i + 1], a->values[3 * i + 2]});
  return out;
}

} // namespace hvi::lang::draw
