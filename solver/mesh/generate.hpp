// Structured meshes. Every cell is cut by the lower-left/upper-right diagonal or both (2D), or into
// Kuhn's six tetrahedra around the main diagonal (3D). Sides are groups.
#pragma once

#include "solver/mesh/mesh.hpp"

namespace hvi::solver {

/// Groups: left (x low), right; in 2D and 3D also bottom (y low), top; in 3D also back (z low),
/// front. `coordinates[a]` lists the grid lines of axis a, increasing. Throws Failure(limit) beyond
/// 50 million cells. `crossed` (2D): both diagonals, four triangles a cell around a node in its
/// middle.
Mesh structured_mesh(int dim, const std::array<std::vector<double>, 3>& coordinates,
                     bool crossed = false);
std::vector<double> uniform_coordinates(double low, double high, int cells);

/// Uniform refinement: every cell into 2^dim; groups are inherited.
Mesh refine(const Mesh& mesh);

/// The nodes of a tetrahedron in a positive order for which refine() cuts the octahedron in its
/// middle along the shortest of its three diagonals, the best shapes to be had.
std::array<std::int32_t, 4> refinable_order(const std::vector<Point>& nodes,
                                            const std::array<std::int32_t, 4>& cell);

} // namespace hvi::solver
