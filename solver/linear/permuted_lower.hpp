// A symmetric matrix in the order of elimination, as the numeric phase reads it.
#pragma once

#include "solver/linear/pattern.hpp"
#include "solver/linear/sparse.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// The lower triangle of P K P^T by columns. CHOLMOD would make it anew of every matrix, in two
/// transpositions; with the places known a matrix is one pass over its rows.
class PermutedLower {
public:
  PermutedLower() = default;
  /// The pattern of a symmetric K; permutation: position -> unknown.
  PermutedLower(const SparseMatrix& k, std::span<const int> permutation);
  /// Takes the values of a matrix with the same pattern; throws Failure(bad_value) otherwise.
  void assign(const SparseMatrix& k);
  /// Of the assigned matrix, by position.
  const std::vector<double>& diagonal() const { return diagonal_; }
  /// Frees the memory of the values and the diagonal until the next matrix.
  void forget_values() {
    std::vector<double>().swap(value_);
    std::vector<double>().swap(diagonal_);
  }
  const Pattern& pattern() const { return pattern_; }
  const std::vector<double>& values() const { return value_; } ///< in the order of the pattern

private:
  std::size_t entries_of_k_ = 0;
  std::vector<int> unknown_, position_; ///< of each other
  Pattern pattern_;
  std::vector<double> value_, diagonal_;
};

} // namespace hvi::solver
