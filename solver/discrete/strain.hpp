// Strains of a field, cell by cell.
#pragma once

#include "solver/fem/space.hpp"
#include "solver/linear/sparse.hpp"

namespace hvi::solver {

inline int n_cells(const Space& space) {
  return static_cast<int>(space.cell_nodes.size()) / space.nodes_per_cell;
}

/// sym grad u of an unknown in a cell (scalars: grad u, one row), u on all dofs, affine between the
/// cell's vertices.
DenseMatrix cell_strain(const Space& space, const SpaceBlock& block, const Vector& u, int cell);

/// The longest edge from the cell's first vertex.
double cell_size(const Space& space, int cell);

} // namespace hvi::solver
