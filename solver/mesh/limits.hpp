// The size limits of meshes.
#pragma once

namespace hvi::solver {

inline constexpr double max_cells = 50e6;
/// Throws Failure(limit) beyond max_cells.
void check_cell_limit(double cells);

} // namespace hvi::solver
