// The elimination tree of an order: what orders are compared by, and what a symbolic factorisation
// begins with.
#pragma once

#include "solver/linear/vertex_graph.hpp"

#include <span>
#include <utility>
#include <vector>

namespace hvi::solver {

/// Pairs of vertices that are coupled besides the edges of a graph.
using Links = std::vector<std::pair<Long, Long>>;

/// By position in the order it was made for.
struct EliminationTree {
  std::vector<Long> parent;       ///< -1 at a root
  std::vector<Long> count;        ///< nonzeros in the factor's column of a vertex's first unknown
  std::vector<Long> post;         ///< of a postorder, the position of each of its places
  double nonzeros = 0, flops = 0; ///< of the factor
};

/// `order`: position -> vertex. Children with large columns come last in the postorder: what they
/// pass on is still in the cache. Throws Failure(limit) where memory ends.
///
/// Trees: J. W. H. Liu, A compact row storage scheme for Cholesky factors using elimination trees,
/// ACM Trans. Math. Softw. 12 (1986) 127-148. Counts: J. R. Gilbert, E. G. Ng, B. W. Peyton, An
/// efficient algorithm to compute row and column counts for sparse Cholesky factorization, SIAM J.
/// Matrix Anal. Appl. 15 (1994) 1075-1091, with a row as heavy as its vertex has unknowns.
EliminationTree elimination_tree(const VertexGraph& graph, const Links& links,
                                 std::span<const Long> order, CholmodSession& session);

} // namespace hvi::solver
