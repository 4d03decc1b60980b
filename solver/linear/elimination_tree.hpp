// Triangles of a permuted matrix as CHOLMOD wants them, and the elimination tree of an order: what
// orders are compared by, and what the symbolic and the numeric phase of a factorisation begin
// with.
#pragma once

#include "solver/linear/cholmod_session.hpp"

#include <span>
#include <utility>
#include <vector>

namespace hvi::solver {

/// The pattern of a triangle by columns, the rows of each in any order.
struct Triangle {
  std::vector<Long> start{0}, row;

  int size() const { return static_cast<int>(start.size()) - 1; }
  /// CHOLMOD's view of it: stype 1 for an upper, -1 for a lower triangle. Valid as long as this
  /// object stays where it is.
  cholmod_sparse view(int stype);
};

/// Pairs of unknowns that are coupled besides the entries of a matrix.
using Links = std::span<const std::pair<int, int>>;

/// Of P K P^T with the links, K with a symmetric pattern; permutation: position -> unknown.
Triangle triangle(const SparseMatrix& k, Links links, std::span<const Long> permutation,
                  bool upper);

/// By position in the order it was made for.
struct EliminationTree {
  std::vector<Long> parent, count; ///< -1 at a root; nonzeros of a column of the factor
  std::vector<Long> post;          ///< of a postorder, the position of each of its places
};

/// Children with large columns come last in the postorder: what they pass on is still in the cache.
/// Sets lnz and fl of the session. Throws Failure(limit) where memory ends.
EliminationTree elimination_tree(const SparseMatrix& k, Links links,
                                 std::span<const Long> permutation, CholmodSession& session);

} // namespace hvi::solver
