// A change of unknowns, u = T x, in which a few of the u are replaced and the others stay.
//
// Rows of T and of T^-1 are stored for the replaced unknowns only; the other rows are those of the
// identity. A direct solver that factors T^T K T solves K u = b by b' = T^T b, x, u = T x
// (changed_unknowns.hpp).
#pragma once

#include "solver/linear/sparse.hpp"

#include <vector>

namespace hvi::solver {

class BasisChange {
public:
  /// `replaced`: in ascending order; `rows` and `inverse`: of T and T^-1 for them. No row may reach
  /// a replaced unknown of another one's columns but those that it is defined with: T^-1 T = 1.
  BasisChange(std::vector<int> replaced, SparseMatrix rows, SparseMatrix inverse);

  const std::vector<int>& replaced() const { return replaced_; }
  const SparseMatrix& inverse() const { return inverse_; }
  int size() const { return static_cast<int>(rows_.cols()); }

  void to_old(Vector& x) const;     ///< x = T x
  void transposed(Vector& b) const; ///< b = T^T b
  /// T^T K T. Its pattern depends on that of K alone.
  SparseMatrix congruent(const SparseMatrix& k) const;
  /// G T; further columns of G stay. Entries that are rounding of those they are sums of become 0.
  SparseMatrix columns(const SparseMatrix& g) const;

private:
  std::vector<int> replaced_;
  SparseMatrix rows_, inverse_; ///< replaced x all unknowns
  SparseMatrix deviation_;      ///< T - 1
};

} // namespace hvi::solver
