// Unknowns that no entries of a matrix couple.
#pragma once

#include "solver/linear/sparse.hpp"

#include <functional>
#include <vector>

namespace hvi::solver {

/// The pieces of K + H: connected components of the graph of its entries. A piece without a
/// right-hand side has the solution 0. Iterations on all pieces at once leave rounding of the
/// others there, and rows that hold rounding alone have no accuracy of their own.
class Pieces {
public:
  explicit Pieces(const SparseMatrix& k);
  /// Of n rows: `couple_all` calls couple(i, j) for rows that are coupled, enough to join all that
  /// are.
  using Couple = std::function<void(int, int)>;
  Pieces(int n, const std::function<void(const Couple&)>& couple_all);
  /// Of a symmetric pattern of n rows, given column by column.
  Pieces(int n, const std::function<void(int, Vector&)>& column);
  /// The entries of H that are not 0 join pieces of K; those of the last H no longer do.
  void join(const SparseMatrix& h);
  /// x = 0 on the pieces of K + H on which b is 0.
  void leave_at_rest(const Vector& b, Vector& x) const;

  int count() const { return count_; } ///< of K alone

private:
  void number();

  std::vector<int> piece_;  ///< of K, by unknown
  std::vector<int> joined_; ///< by piece of K: one that stands for all it is joined to
  int count_ = 0;
};

} // namespace hvi::solver
