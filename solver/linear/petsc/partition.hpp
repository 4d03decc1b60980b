// Which process has which nodes.
#pragma once

#include "solver/linear/petsc/bridge.h"

#include <vector>

namespace hvi::petsc_module {

struct Partition {
  std::vector<int> place;  ///< of each node in the order of the processes; empty: as they are
  std::vector<int> counts; ///< of nodes, for each process
};

/// Parts of alike size with few entries of K between them (F. Pellegrini, J. Roman, Scotch: a
/// software package for static mapping by dual recursive bipartitioning, HPCN 1996). The same K
/// has the same parts.
Partition partition_of(const HviPetscMatrix& k, const HviPetscUnknowns& unknowns, int parts);

} // namespace hvi::petsc_module
