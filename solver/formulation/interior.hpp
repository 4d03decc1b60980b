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

#include "solver/discrete/state.hpp"
#include "solver/formulation/step_matrix.hpp"
#include "solver/linear/condition_estimate.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// T of all unknowns with its factor, and the modes p_k.
struct Interior {
  /// `t` symmetric, positive definite on the unknowns of `layout`; its factor. Takes what `t` holds
  /// (Eigen's own matrices would copy).
  Interior(SparseMatrix& t, SharedFactor factor, StateLayout layout, std::vector<int> contact);

  int n_contact() const { return static_cast<int>(contact.size()); }
  int n_interior() const { return factor->order().interior; }
  int size() const { return n_contact() + static_cast<int>(forces.size()); } ///< of y

  SparseMatrix t;
  StateLayout layout; ///< of all unknowns
  std::vector<int> contact;
  std::vector<int> position; ///< of an unknown among the contact unknowns, or -1
  SharedFactor factor;
  std::vector<Vector> forces; ///< F_k on unknowns,
  std::vector<Vector> kept;   ///< forward solves of the forces: a backward solve gives p_k
};

/// A state y and its unknowns (expand).
struct KnownField {
  Vector y, unknowns;
};

/// Adds the mode p of a force on the unknowns; returns the force on y (r_c and a 1).
Vector add_mode(Interior& interior, const Vector& f);
/// The same where `forward` has made y of the interior and r of it.
Vector add_mode(Interior& interior, const Vector& f, Vector y, const Vector& r);
/// y of a state u: its contact values, and a mode of its own for what they do not explain.
Vector add_state(Interior& interior, const Vector& u);
/// diag(S, 1)
SparseMatrix condensed_matrix(const Interior& interior);
/// x = E c + sum_k phi_k p_k of y = [c; phi], on all unknowns: a backward solve.
void expand(const Interior& interior, const Vector& y, Vector& x);
/// The same of several in one backward solve, a row each in the order of elimination, some rows of
/// zeros after them. The bits of a row do not depend on the others.
void expand(const Interior& interior, std::span<const Vector* const> y, DenseMatrix& x);
/// A row of it on all unknowns.
void take_row(const Interior& interior, const DenseMatrix& x, int row, Vector& unknowns);
/// f = sum_k y_k F_k
void force_of_modes(const Interior& interior, const Vector& y, Vector& f);
/// respond (step_matrix.hpp) with K = gamma T on all unknowns; `matrix` is that of the states.
bool respond(const Interior& interior, std::span<const Vector> forces, StepMatrix& matrix,
             double gamma, const InequalityState& at, std::vector<Vector>& x,
             std::vector<Vector>& xi);

} // namespace hvi::solver
