// Products with a symmetric matrix that read half of it: its diagonal and upper blocks. The
// products of the time loop are bound by memory, as the triangular solves are.
#pragma once

#include "solver/linear/sparse.hpp"

#include <algorithm>
#include <cstddef>
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
  /// A by rows, zeros in blocks included: the same pattern for all matrices of one.
  SparseMatrix by_rows() const;
  const Vector& diagonal() const { return diagonal_entries_; }
  /// f(i, j, a_ij) of every entry of A, in an order of its own.
  template <class F>
  void for_entries(const F& f) const;
  double bytes() const;

private:
  BlockRows blocks_;
  Vector diagonal_entries_;
  DenseMatrix dense_;                 ///< the whole matrix as one block, or empty
  mutable std::vector<double> x_, y_; ///< of blocks of 3, padded to 4
};

template <class F>
void SymmetricBlocks::for_entries(const F& f) const {
  for (int i = 0; i < dense_.rows(); ++i)
    for (int j = 0; j < dense_.cols(); ++j) f(i, j, dense_(std::max(i, j), std::min(i, j)));
  if (dense_.size() > 0) return;
  const int size = blocks_.size;
  const auto each = [&](const std::vector<double>& blocks, int at, const auto& visit) {
    const double* v = blocks.data() + static_cast<std::ptrdiff_t>(size * size) * at;
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c) visit(r, c, v[size * r + c]);
  };
  for (int i = 0; i < blocks_.rows; ++i) {
    each(blocks_.diagonal, i,
         [&](int r, int c, double value) { f(size * i + r, size * i + c, value); });
    for (int at = blocks_.start[i]; at < blocks_.start[i + 1]; ++at)
      each(blocks_.upper, at, [&](int r, int c, double value) {
        const int row = size * i + r, column = size * blocks_.column[at] + c;
        f(row, column, value), f(column, row, value);
      });
  }
}

} // namespace hvi::solver
