// Extreme generalised eigenvalues of sparse forms against a Gram matrix: the constants of the
// theory.
#pragma once

#include "solver/linear/factorisation.hpp"
#include "solver/linear/sparse.hpp"

#include <functional>
#include <memory>
#include <optional>

namespace hvi::solver {

/// The Gram matrix G of V on the unknowns, factored once: all constants are relative to its norm.
class GramForm {
public:
  /// Throws Failure(not_coercive) when G has a kernel (the norm is none).
  explicit GramForm(SparseMatrix g);

  const SparseMatrix& matrix() const { return g_; }
  /// Another one of the same pattern: the analysis is kept. Throws as the constructor does.
  void replace(SparseMatrix g) {
    g_ = std::move(g);
    factorisation_->factor(g_);
  }
  void solve(const Vector& b, Vector& x) const { hvi::solver::solve(*factorisation_, b, x); }

  /// Extremes of <K v, v> / <G v, v> for the symmetric part of K, to 1e-9, by Lanczos' method
  /// (lanczos.hpp); in small spaces by the dense solver. Nothing when the iteration does not
  /// converge.
  /// `below`: a lower bound of the least one where it is known (0: K may be positive definite).
  /// Just under it K is shifted and inverted, so that clusters at the bound converge at once; a
  /// negative one is bracketed by powers of a thousand first.
  std::optional<double> least(const SparseMatrix& k, double below = 0.0) const;
  std::optional<double> largest(const SparseMatrix& k) const;
  /// Are all of them above this, K being symmetric? By a factorisation.
  bool above(const SparseMatrix& k, double value) const;
  /// ||E|| as an operator from V to its dual: sqrt of the largest eigenvalue of E^T G^-1 E.
  std::optional<double> norm(const SparseMatrix& e) const;

private:
  SparseMatrix g_;
  std::unique_ptr<Factorisation> factorisation_;
};

/// The least eigenvalue of S p = l M p, to 1e-9, by S^-1 and M as maps on n numbers, both symmetric
/// and positive definite; by the same method. Nothing when the iteration does not converge.
using LinearMap = std::function<Vector(const Vector&)>;
std::optional<double> least_by_inverse(Eigen::Index n, const LinearMap& s_inverse,
                                       const LinearMap& m);

} // namespace hvi::solver
