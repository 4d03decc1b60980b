// Strains of a field, cell by cell; see strain.hpp.
#include "solver/discrete/strain.hpp"

#include "solver/fem/geometry.hpp"
#include "solver/linear/dense.hpp"

namespace hvi::solver {
namespace {

/// x_j - x_0 of the vertices j = 1 .. dim, a column each.
DenseMatrix edges_of(const Space& space, int cell) {
  const int dim = space.mesh->dim;
  const auto nodes = space.nodes_of_cell(cell);
  DenseMatrix out(dim, dim);
  for (int j = 0; j < dim; ++j)
    for (int i = 0; i < dim; ++i)
      out(i, j) = space.nodes[nodes[j + 1]][i] - space.nodes[nodes[0]][i];
  return out;
}

} // namespace

DenseMatrix cell_strain(const Space& space, const SpaceBlock& block, const Vector& u, int cell) {
  const int dim = space.mesh->dim, n = block.components;
  const auto nodes = space.nodes_of_cell(cell);
  DenseMatrix moved(n, dim);
  for (int j = 0; j < dim; ++j)
    for (int c = 0; c < n; ++c)
      moved(c, j) =
          u[space.dof(nodes[j + 1], block.first + c)] - u[space.dof(nodes[0], block.first + c)];
  const DenseMatrix gradient =
      solve_square(edges_of(space, cell).transpose(), moved.transpose()).transpose();
  if (n != dim) return gradient;
  DenseMatrix strain = 0.5 * (gradient + gradient.transpose());
  if (!has_hoop(space, block)) return strain;
  double x = 0.0, along = 0.0; // at the centroid, each three times
  for (int k = 0; k <= dim; ++k) {
    x += space.nodes[nodes[k]][0];
    along += u[space.dof(nodes[k], block.first)];
  }
  strain.conservativeResizeLike(DenseMatrix::Zero(3, 3));
  strain(2, 2) = along / x;
  return strain;
}

double cell_size(const Space& space, int cell) {
  return edges_of(space, cell).colwise().norm().maxCoeff();
}

} // namespace hvi::solver
