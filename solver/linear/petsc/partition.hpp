// Which process has which nodes.
#pragma once

#include "solver/linear/petsc/bridge.h"

#include <vector>

namespace hvi::petsc_module {

struct Partition {
  std::vector<int> place;  ///< of each node in the order of the processes; empty: as they are
  std::vector<int> counts; ///< of nodes, for each process
};

/// Parts of alike size with few entries of K between them (G. Karypis, V. Kumar, A fast and high
/// quality multilevel scheme for partitioning irregular graphs, SIAM J. Sci. Comput. 20 (1998)
/// 359-392). The same K has the same parts.
Partition partition_of(const HviPetscMatrix& k, const HviPetscUnknowns& unknowns, int parts);

} // namespace hvi::petsc_module
