// K = rate A + B + sum_m w0_m E_m of a step with its factor, condensed to the contact unknowns.
#pragma once

#include "solver/inequality/inequality.hpp"
#include "solver/linear/correction_solves.hpp"
#include "solver/linear/symmetric_blocks.hpp"
#include "solver/time/contact.hpp"
#include "solver/time/operators.hpp"
#include "solver/time/rounding.hpp"
#include "solver/time/shared_work.hpp"

#include <memory>

namespace hvi::solver {

/// What a correction did.
struct Correction {
  InequalityReport report;
  double moved = 0.0; ///< max |c' - c| / max |c'|; without laws 100 max |d' - d| / max |d'|
};

class StepMatrix {
public:
  /// Keeps references to all three. `gamma`: coefficients of the base matrices.
  /// `like`: one for another step size, whose analysis is taken over; it must outlive the first
  /// `factor`.
  StepMatrix(const Operators& operators, const Contact& contact, const InequalityOptions& options,
             const StepMatrix* like = nullptr);

  /// What laws see moves so much faster than the unknowns (law_factors), from the next `factor` on.
  void set_law_factors(std::vector<double> factors) { law_factors_ = std::move(factors); }
  const std::vector<double>& law_factors() const { return law_factors_; }
  /// Numeric factorisation for these coefficients; the pattern is analysed the first time only.
  /// Throws Failure(not_coercive).
  void factor(const Vector& gamma);

  /// Is the problem of this matrix convex, whatever the load? (InequalitySolver::convex)
  bool unique() { return !solver_ || solver_->convex(); }

  /// Null when nothing is condensed.
  const Factorisation* factorisation() const { return factorisation_.get(); }
  const Vector& gamma() const { return gamma_; }
  const SparseMatrix& k() const { return k_; }

  /// One correction of the increment d with contact part c, given gap = b - K d: solves
  ///     S c' + G_c^T W xi' = S c + (gap condensed),   xi' in dj(G_c c' + offset)
  /// and adds to d the x with K x = gap on the interior and c' - c on the contact unknowns. `state`
  /// is where the search starts, and then holds (c', xi'). With an exact factor one correction of
  /// d = 0 is the solution; more of them are iterative refinement. `rhs`: gap + K d where the
  /// caller has it, else null. `couple_bounds`: finds the bounds of coupled laws, too.
  Correction correct(const Vector& gap, const Vector* rhs, bool couple_bounds,
                     CorrectionSolves& solves, InequalityState& state, Vector& d);

  /// The first correction: the same with d = 0, whatever d holds.
  InequalityReport start(const Vector& gap, InequalityState& state, Vector& d);

  /// K_ii of the contact unknowns.
  const Vector& contact_diagonal() const { return contact_diagonal_; }
  /// K once more for products, in half the memory; empty until `halve`, or if K is not symmetric.
  const SymmetricBlocks& half() const { return half_; }
  /// From the base matrices' own.
  void halve(std::span<const SymmetricBlocks> bases) {
    if (half_.empty()) half_ = SymmetricBlocks::sum(bases, gamma_);
    if (half_.empty()) half_ = SymmetricBlocks(k_);
  }

  /// rounding_growth of K; 0 where there is no factor of it.
  double growth() {
    return factorisation_ ? rounding_growth(k_, *factorisation_.operator->()) : 0.0;
  }
  /// The condition number of K, estimated; factors K where there is no factor of it.
  double condition();
  /// x = how the unknowns move, to first order, under each force, with the multipliers' change xi:
  /// (K + G^T W D G) x = force. `at`: a solution of the laws' problem, with c = 0 at the state that
  /// the laws were prepared for. False where that matrix has no factor.
  bool respond(std::span<const Vector> forces, const InequalityState& at, std::vector<Vector>& x,
               std::vector<Vector>& xi);
  /// The same of forces that are condensed to the contact unknowns.
  bool respond_there(std::span<const Vector> r, const InequalityState& at, std::vector<Vector>& c,
                     std::vector<Vector>& xi) {
    return solver_->respond(at, r, c, xi);
  }

  FactorStatistics statistics() const;
  double bytes() const; ///< held besides the factorisation
  void save(std::ostream& out) const;
  /// Factors again for the saved coefficients.
  void restore(std::istream& in);
  double seconds_inequality = 0, seconds_triangular = 0; ///< of the clock on the wall, so far

private:
  void make_factor();
  void condense(const Vector& gap, const Vector* rhs, CorrectionSolves& solves,
                InequalityState& state);
  void expand(const InequalityState& state, CorrectionSolves& solves, Correction& out);
  Correction solve(const Vector& gap, const Vector* rhs, bool couple_bounds,
                   CorrectionSolves& solves, InequalityState& state);

  const Operators& operators_;
  const Contact& contact_;
  InequalityOptions options_;
  const StepMatrix* like_;
  Vector gamma_;
  std::vector<double> law_factors_; ///< by law term; empty: they are 1
  SparseMatrix k_;
  SymmetricBlocks half_;
  SharedFactor factorisation_; ///< absent when nothing is condensed
  std::unique_ptr<ReducedOperator> reduced_;
  std::unique_ptr<InequalitySolver> solver_;
  Vector r_, x_, c_, product_; ///< x_: the correction; c_: d on the contact unknowns
  Vector contact_diagonal_;
};

} // namespace hvi::solver
