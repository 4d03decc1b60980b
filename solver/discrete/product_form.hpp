// What decides about uniqueness where several unknowns act on each other.
#pragma once

#include "solver/kernel/slot.hpp"
#include "solver/linear/sparse.hpp"
#include "solver/plan/couplings.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

/// Weights w_b of the equations of a problem K x + M* xi = f with several unknowns b: two solutions
/// differ by e with  sum_b w_b <(K e)_b + (M* dxi)_b, e_b> = 0.  K has one e for every f, hence the
/// problem one solution, where sym(W (K - D)) is positive definite on the unknowns with forms of
/// their own, D the descent of the laws, and does not see the others (multipliers: a pressure).
/// (D. Boffi, F. Brezzi, M. Fortin, Mixed Finite Element Methods and Applications, 2013, has the
/// theory of those.) Where one unknown drives others and they do not act back, by themselves or
/// through others, w of its equation may be as large as one likes beside theirs: such a coupling
/// does not count.
class ProductForm {
public:
  /// `of_unknown`: by row, which unknown it is of. `with_laws`: by unknown, do laws act on it? Its
  /// weight is positive then; else it has the sign of the unknown's own form. In size the weights
  /// are those that cancel most of the couplings, w_a K_ab + w_b K_ba^T, from the first unknown on;
  /// where that needs the other sign they make both alike.
  /// `couplings`: of the whole problem, of which K may be one form.
  ProductForm(const SparseMatrix& k, std::span<const std::uint8_t> of_unknown,
              std::span<const char> with_laws, const Couplings& couplings);

  /// sym(W form).
  SparseMatrix weighted(const SparseMatrix& form) const;
  /// The same with a diagonal for multipliers that it does not see, of the size of the others' own
  /// forms: positive definite where sym(W form) is on the others and sees no multiplier.
  SparseMatrix symmetric_part(const SparseMatrix& form) const;
  /// Has no form of its own: a multiplier.
  bool is_multiplier(int unknown) const { return multiplier_[static_cast<std::size_t>(unknown)]; }
  double weight(int unknown) const { return weights_[static_cast<std::size_t>(unknown)]; }
  /// Of what an unknown's equation has of another one; 0: it does not count.
  double weight(std::size_t unknown, std::size_t of) const {
    return both_ways_[unknown][of] ? weights_[unknown] : 0.0;
  }

private:
  static constexpr std::size_t most = slot::most_unknowns;
  std::span<const std::uint8_t> of_unknown_;
  std::array<double, most> weights_;
  std::array<std::array<bool, most>, most> both_ways_{}; ///< they act on each other, or are one
  std::array<bool, most> multiplier_{};
  std::array<std::array<double, most>, most> sizes_{}; ///< by block: of the entries of W K
};

} // namespace hvi::solver
