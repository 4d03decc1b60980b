// See cell_parts.hpp.
#include "solver/mesh/cell_parts.hpp"

#include "solver/common/failure.hpp"
#include "solver/common/metis_turn.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <new>
#include <numeric>

namespace hvi::solver {

std::vector<std::int32_t> parts_of_cells(const Mesh& mesh, int parts) {
  const std::size_t n_cells = mesh.cells.size();
  std::vector<std::int32_t> out(n_cells, 0);
  if (parts < 2) return out;
  if (n_cells <= static_cast<std::size_t>(parts)) {
    std::iota(out.begin(), out.end(), 0);
    return out;
  }
  std::vector<idx_t> start{0}, corner, part_of_node(mesh.nodes.size()), part(n_cells);
  for (const auto& cell : mesh.cells) {
    corner.insert(corner.end(), cell.begin(), cell.begin() + mesh.nodes_per_cell());
    start.push_back(static_cast<idx_t>(corner.size()));
  }
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  auto cells = static_cast<idx_t>(n_cells), nodes = static_cast<idx_t>(mesh.nodes.size());
  idx_t shared = mesh.nodes_per_facet(), wanted = parts, cut = 0;
  const std::scoped_lock lock(metis_turn());
  const int answer =
      METIS_PartMeshDual(&cells, &nodes, start.data(), corner.data(), nullptr, nullptr, &shared,
                         &wanted, nullptr, options.data(), &cut, part.data(), part_of_node.data());
  if (answer == METIS_ERROR_MEMORY) throw std::bad_alloc();
  if (answer != METIS_OK)
    throw Failure(FailureKind::output, {}, "METIS finds no parts of the mesh", "take one process");
  std::copy(part.begin(), part.end(), out.begin());
  return out;
}

} // namespace hvi::solver
