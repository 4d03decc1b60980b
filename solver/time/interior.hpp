// The interior that follows from the contact unknowns when all tensors are multiples of one.
//
// With one base matrix T every step reads  T (gamma d + what is known) + G^T W xi = sum_k g_k(t)
// F_k. Write a state as u = E c + sum_k phi_k p_k: E c has the values c on the contact unknowns and
// no force on the interior, p_k is zero on the contact unknowns and has the force F_k on the
// interior. The interior rows are then the same scheme for each number phi_k, and the contact rows
//
//   S (gamma dc + what is known of c) + G_c^T W xi = sum_k g_k(t) (F_k,c - T_cI p_k),
//
// S the Schur complement of T. So the unknowns of a run are y = [c; phi], with the matrix
// diag(S, 1), and a full field costs one forward and backward solve: T_II u_I = sum_k phi_k F_k,I -
// T_Ic c.
#pragma once

#include "solver/linear/condition_estimate.hpp"
#include "solver/time/state.hpp"
#include "solver/time/step_matrix.hpp"

#include <memory>
#include <span>
#include <vector>

namespace hvi::solver {

class Interior {
public:
  /// `t` symmetric, positive definite on the unknowns of `layout`; its factor. Takes what `t` holds
  /// (Eigen's own matrices would copy).
  Interior(SparseMatrix& t, SharedFactor factor, StateLayout layout, std::vector<int> contact);

  /// Adds the mode p of a force on the unknowns; returns the force on y (r_c and a 1).
  Vector add_mode(const Vector& f);
  /// y of a state u: its contact values, and a mode of its own for what they do not explain.
  Vector add_state(const Vector& u);
  int n_contact() const { return static_cast<int>(contact_.size()); }
  int size() const { return n_contact() + static_cast<int>(forces_.size()); }
  SparseMatrix matrix() const; ///< diag(S, 1)

  /// Full vector of y: a forward and a backward solve.
  void scatter(const Vector& y, Vector& full);
  /// Makes these dofs available without triangular solves; prepares one row for each by a solve.
  void observe(std::span<const int> dofs);
  /// Only the observed dofs and the contact unknowns of `full` are set.
  void scatter_observed(const Vector& y, Vector& full) const;

  /// On all unknowns: max_i |R|_i / (|T|(|a| + |b|) + |f|)_i with R = f - T (a + b) - G^T W xi,
  /// where a and b are the states that `known` and `change` stand for (each counts in the scale:
  /// they may cancel, as at the end of a cycle) and f the load that `load` stands for.
  /// With |T||a + b| in its place, which is not larger, where that is within `enough`: it takes one
  /// state instead of two.
  double equilibrium(const Vector& known, const Vector& change, const Vector& load,
                     const Vector& xi, double enough);
  /// What `equilibrium` is asked of one step.
  struct Question {
    Vector known, change, load, xi;
  };
  /// The same for up to 16 steps in one reading of the factor and of T. A step's answer does not
  /// depend on the steps it is asked with.
  std::vector<double> equilibria(std::span<const Question> steps, double enough);
  /// On all unknowns: T, the layout, the vector of y, and the condition of T.
  const SparseMatrix& matrix_of_all() const { return t_; }
  const StateLayout& layout() const { return layout_; }
  void unknowns_of(const Vector& y, Vector& x) { expand(y, x); }
  double condition() { return estimate_condition(t_, *factor_); }
  /// respond (step_matrix.hpp) with K = gamma T on all unknowns; `matrix` is that of the states.
  bool respond(std::span<const Vector> forces, StepMatrix& matrix, double gamma,
               const InequalityState& at, std::vector<Vector>& x, std::vector<Vector>& xi);
  static constexpr int most_steps = 2 * RightHandSides::at_once;
  SparseMatrix force; ///< G^T W on all unknowns
  FactorStatistics statistics() const { return factor_.statistics(); }

private:
  void expand(const Vector& y, Vector& x);
  void force_of_modes(const Vector& y, Vector& f) const;
  void expand_all(std::span<const Vector* const> y, DenseMatrix& x);
  int n_interior() const { return factor_->order().interior; }

  SparseMatrix t_;
  StateLayout layout_; ///< of the full problem
  std::vector<int> contact_, position_;
  SharedFactor factor_;
  std::vector<Vector> forces_; ///< F_k on unknowns,
  std::vector<Vector> kept_;   ///< forward solves of the forces: a backward solve gives p_k
  struct Observed {
    int dof, unknown;
    Vector row;                ///< over c; empty: a contact unknown
    std::vector<double> modes; ///< p_k there
  };
  std::vector<Observed> observed_;
  Vector scattered_, x_; ///< the y last asked for whole, and its unknowns
  Vector state_, f_, gap_, change_gap_, scale_, work_;
};

} // namespace hvi::solver
