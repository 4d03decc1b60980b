// A mesh in parts, for as many processes.
#pragma once

#include "solver/mesh/mesh.hpp"

namespace hvi::solver {

/// The part of each cell: parts with alike numbers of cells and few facets between them (G.
/// Karypis, V. Kumar, A fast and high quality multilevel scheme for partitioning irregular graphs,
/// SIAM J. Sci. Comput. 20 (1998) 359-392), by METIS. The same mesh has the same parts. Where there
/// are fewer cells than parts, some are empty. Throws Failure(output) where METIS finds none: it is
/// what the files of results are cut by.
std::vector<std::int32_t> parts_of_cells(const Mesh& mesh, int parts);

} // namespace hvi::solver
