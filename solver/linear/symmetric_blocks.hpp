// Products with a symmetric matrix that read half of it: its diagonal and upper blocks. The
// products of the time loop are bound by memory, as the triangular solves are.
#pragma once

#include "solver/linear/sparse.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// Blocks on and above the diagonal, row by row.
struct BlockRows {
  int size = 0, rows = 0; ///< of a block, and of rows of blocks
  std::vector<int> start, column;
  std::vector<double> diagonal, upper;
};

/// The upper triangle in dense blocks of 1, 2 or 3 (the components of a node), whichever is the
/// largest that the pattern fills. One index a block instead of one an entry. A matrix of which
/// half is filled is one block.
class SymmetricBlocks {
public:
  SymmetricBlocks() = default;
  /// Empty (see `empty`) when A is not square and symmetric to rounding; `known`: that is not
  /// checked.
  explicit SymmetricBlocks(const SparseMatrix& a, bool known = false);
  /// sum_b factor_b A_b; empty when the patterns differ.
  static SymmetricBlocks sum(std::span<const SymmetricBlocks> parts, const Vector& factors);

  bool empty() const { return blocks_.size == 0; }
  /// y += A x. The order of the additions is always the same.
  void add_product(const Vector& x, Vector& y) const;
  /// x^T A x
  double energy(const Vector& x) const;
  const Vector& diagonal() const { return diagonal_entries_; }
  double bytes() const;

private:
  BlockRows blocks_;
  Vector diagonal_entries_;
  DenseMatrix dense_;                 ///< the whole matrix as one block, or empty
  mutable std::vector<double> x_, y_; ///< of blocks of 3, padded to 4
};

} // namespace hvi::solver
