// K = L L^T by CHOLMOD with the contact unknowns last: the factor itself, without its solves.
#pragma once

#include "solver/common/factor_entries.hpp"
#include "solver/linear/cholmod_session.hpp"
#include "solver/linear/factorisation.hpp"
#include "solver/linear/large_pages.hpp"
#include "solver/linear/permuted_lower.hpp"

#include <type_traits>

namespace hvi::solver {

template <class Entry>
using SquareOf = Eigen::Matrix<Entry, Eigen::Dynamic, Eigen::Dynamic>;

/// A copy is another one for matrices of the same pattern, not factored yet.
class CholeskyFactor {
public:
  /// Analyses the pattern; what is known of the factor goes to `statistics`.
  CholeskyFactor(const SparseMatrix& k, std::span<const int> contact, OrderStore* known,
                 FactorEntries entries, FactorStatistics& statistics);
  CholeskyFactor(const CholeskyFactor& analysed);
  CholeskyFactor& operator=(const CholeskyFactor&) = delete;

  FactorEntries entries() const { return entries_; }
  /// From the next `compute` on.
  void take_doubles();
  /// The columns of L on the interior. False where a pivot is not positive; `take_diagonal` has to
  /// be asked whether they are any good.
  bool compute(const SparseMatrix& k);
  /// The lower triangle of S on the contact unknowns, which is no longer held here. Of the kind
  /// that `entries` says.
  template <class Entry>
  void take_trailing_block(SquareOf<Entry>& s);
  /// The inverse diagonal of L on the interior. `contact`: the diagonal of L22, up to the first
  /// pivot that is not positive. Throws NotFactorable where a pivot is not finite or is nothing but
  /// rounding of doubles.
  void take_diagonal(std::span<const double> contact, std::vector<double>& inverse);

  const EliminationOrder& order() const { return order_; }
  const cholmod_factor& structure() const { return *factor_.l; }
  /// Of the kind that `entries` says.
  template <class Entry>
  const Entry* values() const {
    if constexpr (std::is_same_v<Entry, float>)
      return singles_.data();
    else
      return static_cast<const double*>(factor_.l->x);
  }
  /// f(values) of those that there are.
  template <class F>
  auto with_values(const F& f) const {
    return entries_ == FactorEntries::singles ? f(values<float>()) : f(values<double>());
  }
  double bytes() const; ///< with L22 and S
  /// All that CHOLMOD stores of the columns of the interior.
  std::size_t interior_entries() const;

private:
  [[noreturn]] void fail_at(int position, double pivot) const;
  void make_room();

  FactorEntries entries_;
  CholmodFactor factor_;
  LargeVector<float> singles_; ///< instead of those of the factor
  PermutedLower a_;
  EliminationOrder order_;
};

} // namespace hvi::solver
