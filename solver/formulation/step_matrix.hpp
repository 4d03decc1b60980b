// K = rate A + B + sum_m w0_m E_m of a step with its factor, and the laws condensed onto it.
#pragma once

#include "solver/formulation/factored_matrix.hpp"
#include "solver/inequality/inequality.hpp"

#include <memory>

namespace hvi::solver {

class StepMatrix : public FactoredMatrix {
public:
  /// Keeps references to operators and contact; `like` as for a FactoredMatrix.
  StepMatrix(const Operators& operators, const Contact& contact, const InequalityOptions& options,
             const StepMatrix* like = nullptr)
      : FactoredMatrix(operators, contact, like), contact_(contact), options_(options) {}

  /// What laws see moves so much faster than the unknowns (law_factors), from the next `factor` on.
  void set_law_factors(std::vector<double> factors) { law_factors_ = std::move(factors); }
  const std::vector<double>& law_factors() const { return law_factors_; }
  /// FactoredMatrix::factor, and S.
  void factor(const Vector& gamma);

  /// The problem of the contact unknowns; null without laws.
  InequalitySolver* laws() const { return solver_.get(); }
  /// S as that problem uses it.
  const ReducedOperator* reduced() const { return reduced_.get(); }
  /// K_ii of the unknowns that laws see.
  const Vector& contact_diagonal() const { return contact_diagonal_; }
  double bytes() const; ///< held besides the factorisation

  /// Its coefficients, of which factor and Schur complement are functions, bit for bit.
  void save(std::ostream& out) const;
  /// Factors again for the saved coefficients.
  void restore(std::istream& in);

private:
  const Contact& contact_;
  InequalityOptions options_;
  std::vector<double> law_factors_; ///< those of its rows by law term; empty: they are 1
  std::unique_ptr<ReducedOperator> reduced_;
  std::unique_ptr<InequalitySolver> solver_;
  Vector contact_diagonal_;
};

/// x = how the unknowns move, to first order, under each force, with the multipliers' change xi:
/// (K + G^T W D G) x = force. `at`: a solution of the laws' problem, with c = 0 at the state that
/// the laws were prepared for. False where that matrix has no factor.
bool respond(const StepMatrix& matrix, std::span<const Vector> forces, const InequalityState& at,
             std::vector<Vector>& x, std::vector<Vector>& xi);

} // namespace hvi::solver
