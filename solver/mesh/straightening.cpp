// What a mesh of second order loses when its cells are read with straight edges.
#include "solver/mesh/straightening.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {
namespace {

/// gmsh's order of the nodes in the middle of edges; a triangle has the first three.
constexpr std::array<std::array<int, 2>, 6> edges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {2, 3}, {1, 3}}};

int n_edges(int dim) { return dim * (dim + 1) / 2; }

/// A node nearer to the middle of its edge than this part of the edge's length is on it.
constexpr double rounding = 1e-9;
/// Of coordinates: far from the origin the middle itself is not more exact.
constexpr double unit = 8 * std::numeric_limits<double>::epsilon();

struct Offset {
  double distance, length;
  bool curved;
};

Offset offset_of(const Point& a, const Point& b, const Point& middle) {
  double size = 0.0;
  Point off{}, along{};
  for (int i = 0; i < 3; ++i) {
    off[i] = middle[i] - (a[i] + b[i]) / 2;
    along[i] = b[i] - a[i];
    size = std::max({size, std::abs(a[i]), std::abs(b[i])});
  }
  const double distance = std::hypot(off[0], off[1], off[2]);
  const double length = std::hypot(along[0], along[1], along[2]);
  return {distance, length, !(distance <= rounding * length + unit * size)};
}

double determinant(int dim, const std::array<Point, 3>& j) {
  if (dim == 1) return j[0][0];
  if (dim == 2) return j[0][0] * j[1][1] - j[0][1] * j[1][0];
  return j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) -
         j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0]) +
         j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0]);
}

/// det of the derivative of x(lambda) = sum lambda_i x_i + 4 lambda_i lambda_j (m_ij - (x_i + x_j)
/// / 2) by the coordinates lambda_1 ... lambda_dim.
double jacobian(int dim, const StraighteningSum::Cell& c, const std::array<double, 4>& lambda) {
  std::array<Point, 3> j{};
  for (int k = 0; k < dim; ++k)
    for (int i = 0; i < 3; ++i) j[k][i] = c.corners[k + 1][i] - c.corners[0][i];
  for (int e = 0; e < n_edges(dim); ++e) {
    const auto [a, b] = edges[e];
    for (int k = 0; k < dim; ++k) {
      const auto slope = [&](int corner) { // of lambda_corner by lambda_{k + 1}
        return corner == 0 ? -1.0 : corner == k + 1 ? 1.0 : 0.0;
      };
      const double change = 4 * (lambda[b] * slope(a) + lambda[a] * slope(b));
      for (int i = 0; i < 3; ++i)
        j[k][i] += change * (c.middles[e][i] - (c.corners[a][i] + c.corners[b][i]) / 2);
    }
  }
  return determinant(dim, j);
}

/// The measure of the curved cell less that of the straight one, exact: the determinant has degree
/// `dim` (for degree 3 P. Keast, Moderate-degree tetrahedral quadrature formulas, Comput. Methods
/// Appl. Mech. Engrg. 55 (1986) 339-348).
double change_of_measure(int dim, const StraighteningSum::Cell& c) {
  if (dim == 1) return 0.0;
  const auto with = [&](double special, int at, double others) {
    std::array<double, 4> lambda{};
    for (int k = 0; k <= dim; ++k) lambda[k] = k == at ? special : others;
    return jacobian(dim, c, lambda);
  };
  StraighteningSum::Cell straight = c;
  for (int e = 0; e < n_edges(dim); ++e)
    for (int i = 0; i < 3; ++i)
      straight.middles[e][i] = (c.corners[edges[e][0]][i] + c.corners[edges[e][1]][i]) / 2;
  const double flat = jacobian(dim, straight, {});
  double mean = dim == 3 ? -0.8 * with(0.25, 0, 0.25) : 0.0;
  for (int k = 0; k <= dim; ++k)
    mean += dim == 3 ? 0.45 * with(0.5, k, 1.0 / 6) : with(0.0, k, 0.5) / 3;
  const double reference = dim == 2 ? 0.5 : 1.0 / 6;
  return reference * (flat < 0.0 ? flat - mean : mean - flat);
}

} // namespace

void StraighteningSum::add(const Cell& cell) {
  bool any = false;
  for (int e = 0; e < n_edges(dim_); ++e) {
    const auto off =
        offset_of(cell.corners[edges[e][0]], cell.corners[edges[e][1]], cell.middles[e]);
    any = any || off.curved;
    if (seen_[cell.indices[e]]) continue;
    seen_[cell.indices[e]] = true;
    ++sum_.edges;
    if (!off.curved) continue;
    ++sum_.curved;
    sum_.relative = std::max(sum_.relative, off.distance / off.length);
    if (off.distance <= sum_.offset) continue;
    sum_.offset = off.distance;
    sum_.at = cell.middles[e];
  }
  if (any) sum_.gain -= change_of_measure(dim_, cell);
}

} // namespace hvi::solver
