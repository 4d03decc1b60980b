// The part of a discretisation that one of several processes assembles on: the cells that its nodes
// are in.
//
// The rows of a node are sums over its cells, so that a process with all cells of its nodes has
// their rows to the last bit as one process would, and rows of other nodes in part, which it leaves
// out: cells between two processes are computed by both, and nothing is added up afterwards.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/state.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

struct OwnCells {
  Discretisation discretisation; ///< of the cells, and their facets in the parts that are needed
  /// The unknowns of the process's nodes come first, in their order; then what else its rows have
  /// columns of: unknowns of other processes and imposed values.
  StateLayout layout;
};

/// Which entries of a whole state these are.
struct OwnEntries {
  std::vector<std::int32_t> state; ///< of each entry of OwnCells::layout
  int unknowns = 0;                ///< its first entries: those of the process's nodes
  std::vector<std::int32_t> cells; ///< of the whole mesh, in their order
};

/// The process of each node: parts of alike size of those that have unknowns, with few cells
/// between them (METIS, as parts_of_cells). Nodes without unknowns: 0.
std::vector<std::int32_t> parts_of_nodes(const Space& space, const StateLayout& layout, int parts);

/// Writes the cells of process p as bytes. `parts`: of the plan, which its forms act on; `also`:
/// entries of a state that its rows have columns of, wherever they are.
OwnEntries put_own_cells(StateWriter& w, const Discretisation& discretisation,
                         const StateLayout& layout, std::span<const std::int32_t> part_of_node,
                         int p, std::span<const int> parts,
                         std::span<const std::int32_t> also = {});
/// Reads them where they are to stay: the space points into the mesh.
void get_own_cells(StateReader& r, OwnCells& out);

} // namespace hvi::solver
