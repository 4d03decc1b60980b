// The balance of forces of a step: its equation, and what an increment leaves of it.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/imposed_values.hpp"
#include "solver/kernel/slot.hpp"
#include "solver/linear/symmetric_blocks.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/evolution.hpp"
#include "solver/step/step_load.hpp"

#include <array>
#include <span>
#include <vector>

namespace hvi::solver {

/// Step n:   K_n d + G^T W xi = rhs,   u_n = known + d.
///
/// Its matrix K_n may differ a little from K, which has a factor (q(t, s) changes it in every
/// step): K_n = K + sum_b change_b T_b, and that part is moved to the right-hand side with an
/// expected increment, rhs = rhs_n - sum_b change_b T_b expected.
struct StepEquation {
  int n = 0;
  Vector known;    ///< state u_{n-1} with the values imposed at t_n
  Vector rhs;      ///< on the unknowns
  Vector change;   ///< by base matrix
  Vector expected; ///< state
  /// Is K_n the factored matrix?
  bool exact() const { return change.isZero(0.0); }
};

/// An increment, and what it leaves of the equation.
struct Trial {
  Vector d;   ///< on the unknowns
  Vector kd;  ///< K d, K the factored matrix
  Vector gap; ///< rhs - K_n d, without the reactions
  Vector z;   ///< the laws' arguments
  Vector dz;  ///< and their change in the step, where it was asked for
};

/// What an increment leaves of the equation of its step.
struct EquationResidual {
  double error = 0.0;    ///< componentwise backward error of the equation
  double mismatch = 0.0; ///< of that, what comes from the part of K_n that its factor lacks
};

class Balance {
public:
  /// Keeps references to all of them.
  Balance(const Plan& plan, const Discretisation& discretisation, const Formulation& formulation,
          const Evolution& evolution);

  /// gamma with K_n = sum_b gamma_b T_b, in the step that was begun.
  Vector coefficients(int n) const;
  /// out = u_{n-1} with the values imposed at t_n.
  void known_state(int n, Vector& out);
  /// Before step n, with the forms of the accepted states: what its equation has of the step before
  /// from forms and loads that states change is kept.
  void note_past(int n);
  /// Sets rhs = f_n - sum_b T_b ( what is known on base matrix b ) - sum_b change_b T_b expected:
  /// one product a base matrix.
  void find_right_hand_side(StepEquation& equation);
  /// Sets kd and gap of trial.d.
  EquationResidual residual(const StepEquation& equation, StepMatrix& matrix, const Vector& xi,
                            Trial& trial);
  /// The error of that residual where what rounding leaves of the terms of the right-hand side, and
  /// of the largest values so far, is no part of it: of an unknown that is at rest beside others
  /// all increments are such rounding, and of one that went back to zero its values, too.
  double error_beside_rounding(const StepEquation& equation, const StepMatrix& matrix,
                               const Vector& xi, const Trial& trial, double tolerance);
  /// By unknown.
  ByUnknown rounding_of_largest() const;
  /// Are values, or a change, of the unknowns rounding of the largest values so far, each of its
  /// own?
  bool is_rounding(const Vector& values) const;
  /// What a check of step n on all rows is asked, its increment being d.
  InteriorEquilibrium::Question question(int n, const Vector& d, const Vector& xi) const;
  void save(StateWriter& w) const;
  void restore(StateReader& r);
  /// The base matrices once more for products, in half the memory; empty: not used.
  std::span<const SymmetricBlocks> halves() const {
    const auto& instead = formulation_.operators().halves;
    return instead.empty() ? halves_ : instead;
  }

  StepLoad load;
  int products = 0; ///< with matrices, so far

private:
  /// Adds |f_n| + sum_b |T_b| |what is known on base matrix b|: the right-hand side before its
  /// terms cancel.
  void add_terms(const StepEquation& equation, double factor, Vector& out);
  /// Adds |K| |the largest values so far of the unknown of each column, or what its loads would
  /// move where laws hold it (find_reach)|.
  void add_past(const StepMatrix& matrix, double factor, Vector& out) const;
  void find_gap_and_scale(const StepMatrix& matrix, const Vector& d, const Vector& rhs,
                          Vector& gap);
  double error_of(const StepMatrix& matrix, const Vector& d, const Vector& gap,
                  const Vector& xi) const;
  void note_largest(const Vector& state);
  int unknown_of(Eigen::Index row) const;

  const Formulation& formulation_;
  const Evolution& evolution_;
  ImposedValues imposed_;
  std::vector<SymmetricBlocks> halves_;
  ByUnknown largest_{};            ///< |values| so far, by unknown
  Vector state_, scale_, product_; ///< room within a call
};

/// K_n is the factored matrix from now on: what was moved goes back.
void take_back_change(const Operators& operators, StepEquation& equation);
/// equilibrium_error (certificate.hpp), whoever has the rows of K.
double error_of_rows(const StepMatrix& matrix, const Vector& d, const Vector& gap,
                     const Vector& scale, const Reactions& reactions, const Vector& xi);
/// Of base matrices and of their halves.
double bytes_of(const Operators& operators, std::span<const SymmetricBlocks> halves);

} // namespace hvi::solver
