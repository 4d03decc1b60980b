// Loads that read states inside bodies: the stress that strains of creep release, swelling, growth;
// and loads that read the solution, which are algebraic states: the heat of viscous flow,
// reactions.
//
//   l(v) = int_part  sum_e F_e(x, t, z) D_e(v),    z the states at the points where they live
#pragma once

#include "solver/assembly/point_form.hpp"
#include "solver/discrete/contact.hpp"
#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/state.hpp"

#include <vector>

namespace hvi::solver {

class StateLoads {
public:
  StateLoads() = default;
  /// On the unknowns of `layout`, or on all dofs where it is null. Throws Failure(bad_value) where
  /// the states of a load live at the points of a law.
  StateLoads(const Problem& problem, const Discretisation& d, const Contact& contact,
             const StateLayout* layout);

  bool none() const { return parts_.empty(); }
  /// out += factor l at time t, the states as in Contact::state_values. Throws Failure(bad_value)
  /// naming the point where a value is not finite.
  void add(double t, const Vector& states, double factor, Vector& out) const;

private:
  struct Part {
    Origin origin;
    PointBlock points;
    std::vector<SparseMatrix> test; ///< by entry: points x unknowns, the values of D_e(v)
    mutable Pointwise values;       ///< of the entries; has room of its own
  };
  std::vector<Part> parts_;
  int dim_ = 0;
  std::vector<int> first_state_;
};

} // namespace hvi::solver
