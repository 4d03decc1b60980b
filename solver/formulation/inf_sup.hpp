// How well the other unknowns see one that has no form of its own, a pressure say.
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/operators.hpp"

#include <optional>

namespace hvi::solver {

/// Where a problem is stated on one mesh. Keeps references.
struct OnMesh {
  const Problem& problem;
  const Discretisation& discretisation;
  const StateLayout& layout;
  const Operators& operators;
  const Contact& contact;   ///< without a change of unknowns
  const SparseMatrix& gram; ///< G of V on the unknowns
};

/// By unknown: has the Gram matrix its mass, for forms and values leave motions free?
std::vector<char> masses_in_gram(const Discretisation& discretisation);
/// The Gram matrix of V on the unknowns, with those masses.
SparseMatrix gram_on_unknowns(const Discretisation& discretisation, const StateLayout& layout);

struct InfSup {
  /// beta = inf_p sup_v c(v, p) / (|v|_V |p|), c the couplings, |p| as in multiplier_norm.hpp;
  /// 0: some p is not seen at all; NaN: not found.
  double constant = 0.0;
  bool without_means = false; ///< no other unknown sees its constants (multiplier_norm.hpp)
  /// Of such constants, by the entries alone: the largest |c_pv| / (|v|_V |p|) of two shape
  /// functions. No unit changes beta over it.
  double size = 0.0;
  /// beta with the v alone that vanish where laws with jumps act; nothing where there are no such
  /// laws. Points that rest there take up any force up to the jump: of two solutions with one v the
  /// p may differ where this is 0, for what p exerts the laws can exert as well.
  std::optional<double> at_rest;

  /// Is every p seen, beyond rounding?
  bool sees_all() const;
  bool sees_all_at_rest() const;
};

/// Nothing for unknowns with a form or a law of their own. Factors a matrix of all unknowns, and
/// where `at_rest` is asked for another one.
std::optional<InfSup> inf_sup(const OnMesh& on, int unknown, bool at_rest = true);

/// InfSup::sees_all_at_rest of all unknowns without a form of their own.
bool sees_multipliers_at_rest(const Problem& problem, const Discretisation& discretisation,
                              const StateLayout& layout, const Operators& operators);

} // namespace hvi::solver
