// Straight-sided cells.
#include "solver/fem/geometry.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hvi::solver {
namespace {

/// Rows of J^-1 are the gradients of lambda_1 .. lambda_dim, with J's columns x_k - x_0.
template <int dim>
CellGeometry geometry_of(const Mesh& mesh, int cell) {
  const auto& corners = mesh.cells[cell];
  const Point& origin = mesh.nodes[corners[0]];
  Eigen::Matrix<double, dim, dim> jacobian;
  for (int k = 0; k < dim; ++k) {
    const Point& corner = mesh.nodes[corners[k + 1]];
    for (int j = 0; j < dim; ++j) {
      jacobian(j, k) = corner[j] - origin[j];
    }
  }
  constexpr double simplices_in_cube = dim == 3 ? 6.0 : dim; // dim!
  CellGeometry geometry;
  geometry.measure = jacobian.determinant() / simplices_in_cube;
  const Eigen::Matrix<double, dim, dim> inverse = jacobian.inverse();
  for (int k = 0; k < dim; ++k) {
    for (int j = 0; j < dim; ++j) {
      geometry.gradient[k + 1][j] = inverse(k, j);
      geometry.gradient[0][j] -= inverse(k, j);
    }
  }
  if (mesh.axisymmetric) {
    for (int k = 0; k <= dim; ++k) {
      geometry.radius[k] = mesh.nodes[corners[k]][0];
    }
  }
  return geometry;
}

/// phi_i / x, or its limit on the axis. Points of sides on the axis that a search has found are off
/// it by rounding.
void hoop_shapes(const CellGeometry& geometry, const Barycentric& point, int first,
                 ShapeTable& shapes) {
  constexpr double rounding = 1e-12;
  double x = 0.0, largest = 0.0;
  for (int k = 0; k < 3; ++k) {
    x += point[k] * geometry.radius[k];
    largest = std::max(largest, geometry.radius[k]);
  }
  const bool on_axis = std::abs(x) <= rounding * largest;
  double* row = shapes.row(first + hoop_row);
  for (int i = 0; i < shapes.size; ++i) {
    row[i] = on_axis ? shapes.at(first + 1, i) : shapes.at(first, i) / x;
  }
  shapes.rows = hoop_row + 1;
}

} // namespace

double circumference(const Mesh& mesh, double x) {
  return mesh.axisymmetric ? 2.0 * std::numbers::pi * x : 1.0;
}

CellGeometry cell_geometry(const Mesh& mesh, int cell) {
  switch (mesh.dim) {
  case 1:
    return geometry_of<1>(mesh, cell);
  case 2:
    return geometry_of<2>(mesh, cell);
  default:
    return geometry_of<3>(mesh, cell);
  }
}

Point point_in_cell(const Mesh& mesh, int cell, const Barycentric& point) {
  Point x{};
  for (int k = 0; k <= mesh.dim; ++k) {
    const Point& corner = mesh.nodes[mesh.cells[cell][k]];
    for (int j = 0; j < mesh.dim; ++j) {
      x[j] += point[k] * corner[j];
    }
  }
  return x;
}

/// From the gradients and the centroid.
Barycentric barycentric_in_cell(const Mesh& mesh, int cell, const Point& x) {
  const auto geometry = cell_geometry(mesh, cell);
  Barycentric out{};
  for (int k = 0; k <= mesh.dim; ++k) out[k] = 1.0 / (mesh.dim + 1);
  const Point centroid = point_in_cell(mesh, cell, out);
  for (int k = 0; k <= mesh.dim; ++k)
    for (int i = 0; i < mesh.dim; ++i) out[k] += geometry.gradient[k][i] * (x[i] - centroid[i]);
  return out;
}

std::array<int, 3> facet_in_cell(const Mesh& mesh, int facet) {
  const Facet& f = mesh.facets[facet];
  const auto& corners = mesh.cells[f.cell];
  std::array<int, 3> local{-1, -1, -1};
  for (int k = 0; k < mesh.dim; ++k) {
    const auto place = std::find(corners.begin(), corners.begin() + mesh.dim + 1, f.nodes[k]);
    local[k] = static_cast<int>(place - corners.begin());
  }
  return local;
}

namespace {

/// Values and, where they are asked for, gradients of the functions of this order: rows of
/// max_cell_nodes numbers.
void fill_rows(int dim, int order, const CellGeometry& geometry, const Barycentric& point,
               bool gradients, double* rows) {
  lagrange_values(dim, order, point, rows);
  if (!gradients) {
    return;
  }
  const int size = lagrange_size(dim, order);
  std::array<double, max_cell_nodes * 4> slopes;
  lagrange_slopes(dim, order, point, slopes.data());
  for (int j = 0; j < dim; ++j) {
    double* row = rows + (1 + j) * max_cell_nodes;
    for (int i = 0; i < size; ++i) {
      double sum = 0.0;
      for (int k = 0; k <= dim; ++k) {
        sum += slopes[i * (dim + 1) + k] * geometry.gradient[k][j];
      }
      row[i] = sum;
    }
  }
}

} // namespace

void evaluate_shapes(const Space& space, const CellGeometry& geometry, const Barycentric& point,
                     bool gradients, ShapeTable& shapes) {
  shapes.size = space.nodes_per_cell;
  const bool hoop = gradients && has_hoop(space);
  fill_rows(space.mesh->dim, space.order, geometry, point, gradients, shapes.row(0));
  shapes.rows = gradients ? 1 + space.mesh->dim : 1;
  if (hoop) hoop_shapes(geometry, point, 0, shapes);
  if (!space.is_mixed()) return;
  std::fill_n(shapes.row(linear_rows), linear_rows * max_cell_nodes, 0.0);
  fill_rows(space.mesh->dim, 1, geometry, point, gradients, shapes.row(linear_rows));
  if (hoop) hoop_shapes(geometry, point, linear_rows, shapes);
}

Derivative decode(const Space& space, int index, Origin origin) {
  const auto b = static_cast<std::size_t>(std::max(0, slot::unknown_of(index)));
  const SpaceBlock& block = space.blocks[std::min(b, space.blocks.size() - 1)];
  const int rows = block.order < space.order ? linear_rows : 0;
  const int own = index - slot::of_unknown(static_cast<int>(b), 0);
  if (own == slot::hoop && has_hoop(space, block)) {
    return {block.first, rows + hoop_row};
  }
  const bool is_value = own >= 0 && own < 3;
  const int component = is_value ? own : (own - 3) / 3;
  const int direction = is_value ? 0 : (own - 3) % 3;
  if (index < 0 || b >= space.blocks.size() || component >= block.components ||
      direction >= space.mesh->dim) {
    throw Failure(FailureKind::bad_value, origin,
                  fmt::format("derivative {} does not exist in a space with {} components in {} "
                              "dimensions",
                              index, space.components, space.mesh->dim));
  }
  return {block.first + component, rows + (is_value ? 0 : 1 + direction)};
}

} // namespace hvi::solver
