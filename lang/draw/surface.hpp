// What is seen of a grid: the triangles of its skin, their normals and the edges that matter.
#pragma once

#include "solver/common/triples.hpp"
#include "solver/output/vtu.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace hvi::lang::draw {

using solver::cross;
using solver::dot;
using solver::minus;
using solver::Point;

/// A vector of length zero stays what it is.
inline Point unit(const Point& a) {
  const double size = solver::norm(a);
  return size > 0.0 ? Point{a[0] / size, a[1] / size, a[2] / size} : a;
}

using Triangle = std::array<std::int32_t, 3>;
using Edge = std::array<std::int32_t, 2>;

/// In 2D the cells, in 3D the faces that one cell only has, ordered counterclockwise seen from
/// outside; quadratic ones cut into four.
struct Skin {
  int dim = 2;
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> cells; ///< by triangle
};
Skin skin_of(const solver::VtuGrid& grid);

/// Angle between two faces from which their common edge is sharp (cosine).
constexpr double sharp = 0.8;

/// One normal per corner of each triangle: the mean over the triangles there that meet without a
/// sharp edge, so that round bodies look round and edged ones edged.
std::vector<std::array<Point, 3>> corner_normals(const Skin& skin,
                                                 const std::vector<Point>& points);
/// Edges of one triangle only, and those where two meet at a sharp angle.
std::vector<Edge> feature_edges(const Skin& skin, const std::vector<Point>& points);

/// Components at every point, component fastest.
struct NodalArray {
  int components = 1;
  std::vector<double> values; ///< empty: the grid has no array of that name
};
/// An array at points as it is; of one of cells the means of those around each point, weighted by
/// their sizes.
NodalArray nodal_array(const solver::VtuGrid& grid, const std::string& name);
/// An array as it is stored, as a number at every point or in every cell: the Euclidean norm of
/// vectors and tensors. No values: the grid has no array of that name.
struct Numbers {
  bool of_cells = false;
  std::vector<double> values;
};
Numbers numbers_of(const solver::VtuGrid& grid, const std::string& name);
/// At the corners of every triangle. Those of a cell have its one value: nothing is smoothed.
std::vector<std::array<double, 3>> corner_numbers(const Skin& skin, const Numbers& numbers);
/// A vector at every point; empty: there is none.
std::vector<Point> nodal_vectors(const solver::VtuGrid& grid, const std::string& name);

} // namespace hvi::lang::draw
