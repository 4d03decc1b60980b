// The operator of the reduced inequality where all unknowns are kept and linear systems are solved
// by iterations.
#pragma once

#include "solver/inequality/inequality.hpp"
#include "solver/linear/iterative_solver.hpp"
#include "solver/linear/matrix_rows.hpp"

#include <memory>
#include <span>

namespace hvi::solver {

class IterativeOperator final : public ReducedOperator {
public:
  /// Keeps references; `solver` is that of k. `several`: of several unknowns.
  IterativeOperator(const MatrixRows& k, bool symmetric, IterativeSolver& solver, bool several)
      : k_(k), symmetric_(symmetric), solver_(solver), several_(several) {}

  int size() const override { return k_.size(); }
  bool symmetric() const override { return symmetric_; }
  void apply(const Vector& c, Vector& out) const override { k_.apply(c, out); }
  void apply_magnitude(const Vector& c, Vector& out) const override { k_.apply_magnitude(c, out); }
  Vector diagonal() const override { return k_.diagonal(); }
  Vector own_stiffness() const override { return k_.own_stiffness(); }
  void column(int j, double* out) const override;
  bool factor(const SparseMatrix& h, std::span<const int> held) override;
  void solve(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-12, x); }
  void solve_rough(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-6, x); }
  void estimate(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-3, x); }
  bool definite() override;
  double aim() const override { return 0.1; }
  const IterativeOperator* iterative() const override { return this; }
  std::unique_ptr<ReducedOperator> unsymmetric() const override {
    return std::make_unique<IterativeOperator>(k_, false, solver_, several_);
  }
  int patience() const override { return 12; }
  double bytes() const override { return solver_.statistics().bytes; }

  const MatrixRows& matrix() const { return k_; } ///< K
  bool several_unknowns() const { return several_; }

  /// As far as iterations come.
  IterativeAnswer answer_to(const Vector& b, double reduction, Vector& x) const;
  /// x with |b - (K + H) x| <= reduction |b|. False: K + H is not positive definite. Throws
  /// Failure(not_certified) where the iterations stagnate before they have come to `enough`.
  bool solve_to(const Vector& b, double reduction, Vector& x, double enough = 0.0) const;
  /// A direction of Newton's method with a search along it: where laws are stiffer than the body by
  /// many decades, iterations stagnate at the rounding of the laws' forces, far from what a factor
  /// leaves.
  void solve_for_direction(const Vector& b, Vector& x) const;

private:
  bool use_laws() const;
  void solve_or_refuse(const Vector& b, double reduction, Vector& x, double enough = 0.0) const;

  const MatrixRows& k_;
  bool symmetric_;
  IterativeSolver& solver_;
  bool several_;
  SparseMatrix h_;
};

} // namespace hvi::solver
