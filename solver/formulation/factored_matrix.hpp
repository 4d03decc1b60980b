// The matrix of a step, K = sum_b gamma_b T_b, with its factor.
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/discrete/dealt_matrices.hpp"
#include "solver/discrete/held_by_laws.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/discrete/shared_work.hpp"
#include "solver/inequality/inequality.hpp"
#include "solver/linear/matrix_rows.hpp"
#include "solver/linear/symmetric_blocks.hpp"

namespace hvi::solver {

class FactoredMatrix {
public:
  /// Keeps references to operators and contact. `like`: one for another step size, whose analysis
  /// is taken over; it must outlive the first `factor`.
  FactoredMatrix(const Operators& operators, const Contact& contact,
                 const FactoredMatrix* like = nullptr)
      : operators_(operators), contact_(contact), like_(like) {}

  /// Of the factors that are made from now on. Whoever takes singles has to correct what he solves.
  void set_entries(FactorEntries entries) { entries_ = entries; }
  /// Called between iterations in place of a factor, from the next `factor` on; what it throws ends
  /// them.
  void call_between_iterations(std::function<void()> what) { between_ = std::move(what); }
  /// Numeric factorisation for these coefficients; the pattern is analysed the first time only.
  /// Throws Failure(not_coercive).
  void factor(const Vector& gamma);

  /// From the next `factor` on K may leave such motions free, which laws hold (held_by_laws.hpp).
  /// Then what is factored is K + hold D on the contact unknowns, D = diag K: corrections with it
  /// are steps of the proximal point method (R. T. Rockafellar, Monotone operators and the proximal
  /// point algorithm, SIAM J. Control Optim. 14 (1976) 877-898), whose limit solves the equation of
  /// K itself. `motions` and `layout` are kept by reference.
  void may_be_free(std::span<const RigidMotions> motions, const StateLayout& layout) {
    motions_ = motions, layout_ = &layout;
  }
  static constexpr double hold = 1e-8;
  /// What K leaves free; null: nothing, and K itself is factored.
  const FreeBody* free_body() const { return free_.get(); }
  /// What is factored, where that is not K.
  SparseMatrix held() const;
  /// out += (held() - K) x, for all unknowns; nothing where K itself is factored.
  void add_held(const Vector& x, Vector& out) const;

  /// S as the laws' problem uses it: the Schur complement, or what is solved where all unknowns are
  /// contact unknowns.
  std::unique_ptr<ReducedOperator> reduced_operator() const;
  /// Of the factor, or of the iterations in its place.
  FactorStatistics statistics() const;

  const Vector& gamma() const { return gamma_; }
  const SparseMatrix& k() const { return k_; }
  /// K where several processes have its rows; null: `k` has them.
  const DealtMatrix* dealt() const { return dealt_.get(); }
  /// Absent where all unknowns are contact unknowns, so that nothing is condensed.
  const SharedFactor& factorisation() const { return factorisation_; }
  /// Is the factor one of singles? Then corrections leave a hundredth of an error, at most.
  bool in_singles() const;
  /// K once more for products, in half the memory, from such matrices of the T_b; empty without
  /// those, or if K is not symmetric. Made at the first call.
  const SymmetricBlocks& half(std::span<const SymmetricBlocks> bases);
  double bytes() const; ///< held besides the factorisation

private:
  void factor_dealt();
  const MatrixRows& rows_of_iterations() const;
  void take_for_a_factor();
  bool has_an_energy() const;
  bool symmetric() const;
  void set_matrix(SparseMatrix& k);
  void prepare_iterations();
  void iterate_with(std::unique_ptr<IterativeSolver> solver);
  template <class Held> // held(i, hold K_ii)
  void for_held(const Held& held) const;

  const Operators& operators_;
  const Contact& contact_;
  const FactoredMatrix* like_;
  FactorEntries entries_ = FactorEntries::doubles;
  std::function<void()> between_;
  std::span<const RigidMotions> motions_;
  const StateLayout* layout_ = nullptr;
  std::shared_ptr<const FreeBody> free_;
  Vector gamma_;
  SparseMatrix k_, held_; ///< the second one for iterations, where motions are free
  SymmetricBlocks half_;
  SharedFactor factorisation_;
  std::unique_ptr<DealtMatrix> dealt_,
      dealt_held_;                              ///< the same, dealt out; null: all rows are here
  std::unique_ptr<HeldRows> rows_;              ///< of k_ or held_, for iterations
  std::unique_ptr<IterativeSolver> iterations_; ///< instead of a factor; reads one of these
};

/// The condition number of K, estimated; factors K where there is no factor of it. 0: K has a free
/// body, and there is none.
double condition(const FactoredMatrix& matrix, const Operators& operators);

} // namespace hvi::solver
