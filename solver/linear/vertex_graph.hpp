// The graph of a matrix with one vertex for unknowns of equal neighbours, as the components of a
// node: its orders and elimination trees are those of the matrix at a fraction of the work
// (C. Ashcraft, Compressed graphs and the minimum degree algorithm, SIAM J. Sci. Comput. 16 (1995)
// 1404-1411).
#pragma once

#include "solver/linear/pattern.hpp"
#include "solver/linear/sparse.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

struct VertexGraph {
  std::vector<int> first;    ///< unknown of each vertex; the last: how many unknowns there are
  Pattern edges;             ///< neighbours of each vertex, itself among them; ascending
  std::vector<Long> member;  ///< 1: contact
  std::vector<Long> contact; ///< the contact vertices in the order of their unknowns

  int size() const { return static_cast<int>(member.size()); }
  int unknowns_of(Long vertex) const { return first[vertex + 1] - first[vertex]; }
  std::span<const Long> neighbours(Long vertex) const {
    return {edges.row.data() + edges.start[vertex], edges.row.data() + edges.start[vertex + 1]};
  }
};

/// Unknowns that follow each other and have the same neighbours make a vertex; contact unknowns
/// only if they follow each other in `contact`, too. K has a symmetric pattern, sorted.
VertexGraph vertex_graph(const SparseMatrix& k, std::span<const int> contact);

} // namespace hvi::solver
