// The matrices of a problem on one mesh, and the constants of the theory they give.
#pragma once

#include "solver/discrete/held_by_laws.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/discrete/product_form.hpp"
#include "solver/formulation/inf_sup.hpp"
#include "solver/formulation/uniqueness.hpp"
#include "solver/hypotheses/laws.hpp"
#include "solver/linear/extremes.hpp"

#include <optional>
#include <vector>

namespace hvi::solver {

class Numbers {
public:
  Numbers(const Plan& plan, const Discretisation& d);

  SparseMatrix of_field(int field) const; ///< the sum of all forms in a field
  /// Of the matrix of a form: its symmetric part; of several unknowns see ProductForm.
  SparseMatrix definite_part(const SparseMatrix& k) const;
  /// With the weights of the equations of `k`; of one unknown there is none.
  std::optional<ProductForm> product_form(const SparseMatrix& k) const;
  bool has_several_unknowns() const { return !contact_.of_unknown.empty(); }
  bool acts_on(int field) const { return operators_.acts_on(field); }
  /// Least eigenvalue against the Gram matrix (0 for no form, NaN when not found). `pointwise`: a
  /// lower bound of it where the form is one of strains alone.
  double coercivity(int field, double pointwise) const;
  /// The same of each unknown's own part of the form; of multipliers infinity. A mass in the Gram
  /// matrix is divided by the square of the body's size here: what they become on a finer mesh does
  /// not depend on units.
  std::vector<double> own_coercivities(int field) const;
  /// The same against the mass matrix: coercivity in H = L2.
  double coercivity_in_h(int field) const;
  /// How well the others see an unknown without a form of its own; nothing for other unknowns.
  std::optional<InfSup> inf_sup(int unknown, bool at_rest = true) const;
  double memory_norm(int m) const;     ///< ||E|| of memory m; NaN when not found
  double asymmetry(int field) const;   ///< max |K_ij - K_ji| / max |K_ij|
  double script_norm(int field) const; ///< ||M||^2 of the arguments of all laws on a field
  /// m - lambda_max(sum m_i M_i^T W M_i), of the laws on a field and the constant m of its form.
  double margin_split(int field, double m) const;
  /// 1 - lambda_max(sum m_i M_i^T W M_i, sym K), K the field's form; minus infinity when K is not
  /// positive definite or a law jumps down.
  double margin_against(int field) const;

  /// sum_i c_i m_i M_i^T W M_i, c_i the factor of the field that law i acts on; without entries
  /// where no law softens; nothing when a law jumps down.
  std::optional<SparseMatrix> descent(const Vector& factors) const;
  /// By field: 1 for this one, else 0.
  Vector only(int field) const;
  bool has_laws_on_rates() const { return !contact_.other_fields.empty(); }

  /// Rigid motions that no form sees, whatever its field; null: there are none.
  const FreeBody* free_body() const { return free_.get(); }
  const Contact& contact() const { return contact_; }
  const StateLayout& layout() const { return layout_; }
  const std::vector<TermConstants>& laws() const { return laws_; }
  TraceNorms traces() const;
  const Operators& operators() const { return operators_; }
  /// Of the fields in a step's equation (TimeScheme::present).
  const Vector& shares() const { return shares_; }

private:
  struct DefinitePart {
    SparseMatrix form;
    std::vector<std::vector<int>> rows; ///< by unknown; of multipliers that it does not see none
    bool couples = false;               ///< entries between unknowns
  };
  DefinitePart definite_part_of(int field) const;
  double least(const SparseMatrix& form, const GramForm& gram, const std::vector<int>& rows,
               double pointwise) const;

  const Problem& problem_;
  const Discretisation& discretisation_;
  StateLayout layout_;
  Operators operators_;
  Contact contact_;
  std::vector<RigidMotions> motions_; ///< that imposed values allow, by unknown
  std::shared_ptr<const FreeBody> free_;
  GramForm gram_; ///< with the mass where there are such motions
  Vector shares_;
  std::vector<TermConstants> laws_;
};

/// lambda_max(sum m_i M_i^T W M_i, sym K) for many K of the same forms. Below 1: the problem with
/// the matrix K has one solution for every load.
class StepRatio {
public:
  /// Keeps a reference.
  explicit StepRatio(const Numbers& numbers) : numbers_(numbers) {}
  /// K = sum_f c_f F_f (step_weights.hpp). Infinite when K is not positive definite or a law jumps
  /// down; 0 when no law softens.
  double operator()(const Vector& c);
  /// By a factor: is sym K - descent positive definite?
  bool below_one(const Vector& c);

private:
  /// sym K with the pattern of the laws' form; false where a law jumps down.
  bool take(const Vector& c, SparseMatrix& k);
  double by_factors(const SparseMatrix& k);
  bool exceeds(const SparseMatrix& k, double ratio);

  const Numbers& numbers_;
  SparseMatrix descent_; ///< of the last c
  bool taken_ = false;
  std::unique_ptr<GramForm> against_, trial_;
};

} // namespace hvi::solver
