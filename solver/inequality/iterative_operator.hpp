// The operator of the reduced inequality where all unknowns are kept and linear systems are solved
// by iterations.
#pragma once

#include "solver/inequality/inequality.hpp"
#include "solver/inequality/own_stiffness.hpp"
#include "solver/linear/iterative_solver.hpp"

#include <cstdint>
#include <memory>
#include <span>

namespace hvi::solver {

class IterativeOperator final : public ReducedOperator {
public:
  /// Keeps references to all; `solver` is that of k. `of_unknown`: by row, which of several
  /// unknowns it is of; empty: there is one.
  IterativeOperator(const SparseMatrix& k, bool symmetric, IterativeSolver& solver,
                    std::span<const std::uint8_t> of_unknown)
      : k_(k), symmetric_(symmetric), solver_(solver), of_unknown_(of_unknown) {}

  int size() const override { return static_cast<int>(k_.rows()); }
  bool symmetric() const override { return symmetric_; }
  void apply(const Vector& c, Vector& out) const override { out.noalias() = k_ * c; }
  void apply_magnitude(const Vector& c, Vector& out) const override;
  Vector diagonal() const override { return k_.diagonal(); }
  Vector own_stiffness() const override { return hvi::solver::own_stiffness(k_); }
  void column(int j, double* out) const override;
  bool factor(const SparseMatrix& h, std::span<const int> held) override;
  void solve(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-12, x); }
  void solve_rough(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-6, x); }
  void estimate(const Vector& b, Vector& x) const override { solve_or_refuse(b, 1e-3, x); }
  bool definite() override;
  double aim() const override { return 0.1; }
  const IterativeOperator* iterative() const override { return this; }
  std::unique_ptr<ReducedOperator> unsymmetric() const override {
    return std::make_unique<IterativeOperator>(k_, false, solver_, of_unknown_);
  }
  int patience() const override { return 12; }
  double bytes() const override { return solver_.statistics().bytes; }

  const SparseMatrix& matrix() const { return k_; } ///< K
  bool several_unknowns() const { return !of_unknown_.empty(); }
  /// |K_ii| max |c_j| over row i, of its own unknown: the size of the row's terms in axes that are
  /// turned.
  double whole_scale(int i, const Vector& c) const;

  /// As far as iterations come.
  IterativeAnswer answer_to(const Vector& b, double reduction, Vector& x) const;
  /// x with |b - (K + H) x| <= reduction |b|. False: K + H is not positive definite. Throws
  /// Failure(not_certified) where the iterations stagnate.
  bool solve_to(const Vector& b, double reduction, Vector& x) const;

private:
  bool use_laws() const;
  void solve_or_refuse(const Vector& b, double reduction, Vector& x) const;

  const SparseMatrix& k_;
  bool symmetric_;
  IterativeSolver& solver_;
  std::span<const std::uint8_t> of_unknown_;
  SparseMatrix h_;
};

} // namespace hvi::solver
