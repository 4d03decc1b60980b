// Which process has which nodes.
#pragma once

#include "solver/linear/petsc/bridge.h"

#include <vector>

namespace hvi::petsc_module {

struct Partition {
  std::vector<int> place;  ///< of each node in the order of the processes; empty: as they are
  std::vector<int> counts; ///< of nodes, for each process
};

/// Vertices that share an edge, both ways and each once.
struct Graph {
  std::vector<int> start{0}, neighbour;
  /// In the place of those that were noted, in any order and more than once.
  explicit Graph(std::vector<std::vector<int>> noted);
  int vertices() const { return static_cast<int>(start.size()) - 1; }
};

/// The part of each vertex: parts of alike weight with few edges between them; empty `weights`: all
/// weigh the same. By METIS, of one thread: Scotch's threads find other parts each time.
std::vector<int> parts_of(Graph graph, std::vector<int> weights, int parts);

/// Parts of alike size with few entries of K between them (G. Karypis, V. Kumar, A fast and high
/// quality multilevel scheme for partitioning irregular graphs, SIAM J. Sci. Comput. 20 (1998)
/// 359-392). The same K has the same parts. Where the caller has dealt rows out: as they are.
Partition partition_of(const HviPetscMatrix& k, const HviPetscUnknowns& unknowns, int parts);

} // namespace hvi::petsc_module
