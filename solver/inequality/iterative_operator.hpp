// The operator of the reduced inequality where all unknowns are kept and linear systems are solved
// by iterations.
#pragma once

#include "solver/inequality/inequality.hpp"
#include "solver/linear/iterative_solver.hpp"

namespace hvi::solver {

class IterativeOperator final : public ReducedOperator {
public:
  /// Keeps references to both; `solver` is that of k.
  IterativeOperator(const SparseMatrix& k, bool symmetric, IterativeSolver& solver)
      : k_(k), symmetric_(symmetric), solver_(solver) {}

  int size() const override { return static_cast<int>(k_.rows()); }
  bool symmetric() const override { return symmetric_; }
  void apply(const Vector& c, Vector& out) const override { out.noalias() = k_ * c; }
  void apply_magnitude(const Vector& c, Vector& out) const override;
  Vector diagonal() const override { return k_.diagonal(); }
  void column(int j, double* out) const override;
  bool factor(const SparseMatrix& h, std::span<const int> held) override;
  void solve(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-12, x); }
  void solve_rough(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-6, x); }
  void estimate(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-3, x); }
  bool definite() override;
  double aim() const override { return 0.3; }
  const IterativeOperator* iterative() const override { return this; }
  std::unique_ptr<ReducedOperator> unsymmetric() const override {
    return std::make_unique<IterativeOperator>(k_, false, solver_);
  }
  int patience() const override { return 12; }
  double bytes() const override { return solver_.statistics().bytes; }

  const SparseMatrix& matrix() const { return k_; } ///< K
  /// |K_ii| max |c_j| over row i: the size of the row's terms in axes that are turned.
  double whole_scale(int i, const Vector& c) const;

  /// x with |b - (K + H) x| <= reduction |b|. False: K + H is not positive definite. Throws
  /// Failure(not_certified) where the iterations stagnate.
  bool solve_to(const Vector& b, double reduction, Vector& x) const;

private:
  bool use_laws() const;
  void solve_or_refuse(const Vector& b, double reduction, Vector& x) const;

  const SparseMatrix& k_;
  bool symmetric_;
  IterativeSolver& solver_;
  SparseMatrix h_;
};

} // namespace hvi::solver
