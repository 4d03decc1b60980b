// What a run with u'' and several unknowns knows at its first time, and what it has to find there.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/formulation/formulation.hpp"

#include <array>
#include <vector>

namespace hvi::solver {

/// An unknown has forms in its derivatives up to the order m: a displacement u'' (2), a temperature
/// theta' (1), a potential none (0). At t_0 its derivatives below m are given, and the m-th one, y,
/// is what the equations say:
///
///   L y + (forms in the given ones) + G^T W xi_0 = f(t_0),
///
/// where a column of L is that of the forms in the m-th derivative of its unknown. So a
/// displacement gets its acceleration, a temperature its rate and a potential its value.
class LeadingForms {
public:
  LeadingForms(const Problem& problem, const Discretisation& discretisation,
               const StateLayout& layout);

  /// On the unknowns.
  SparseMatrix matrix() const;
  /// The m-th derivatives of what is given, from those of all orders 0, 1, 2 (states).
  Vector leading(const std::array<Vector, 3>& derivatives) const;
  /// Puts y where it is the `order`-th derivative.
  void put(const Vector& y, int order, Vector& derivative) const;
  /// Of the forms on what is known: derivatives below the m-th one, and the m-th of imposed values.
  Vector known(const std::array<Vector, 3>& derivatives) const;

private:
  int n_unknowns_;
  std::vector<std::int8_t> order_of_;   ///< m, by state entry
  std::array<SparseMatrix, 3> forms_{}; ///< of u, u', u'': unknowns x state
};

} // namespace hvi::solver
