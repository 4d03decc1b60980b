// The values that are imposed on a run's states.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/state.hpp"

namespace hvi::solver {

class ImposedValues {
public:
  /// Keeps references to all of them.
  ImposedValues(const SpaceSpec& spec, const Discretisation& discretisation,
                const StateLayout& layout)
      : spec_(spec), discretisation_(discretisation), layout_(layout),
        full_(Vector::Zero(layout.n_dofs)) {}

  /// The state with the values of time t in the place of its own; its unknowns stay.
  void put(double t, Vector& state) {
    const Vector unknowns = state.head(layout_.n_unknowns);
    layout_.scatter(state, full_);
    impose(discretisation_.space, spec_, discretisation_.dofs, t, full_);
    layout_.gather(full_, state);
    state.head(layout_.n_unknowns) = unknowns;
  }

private:
  const SpaceSpec& spec_;
  const Discretisation& discretisation_;
  const StateLayout& layout_;
  Vector full_; ///< room within a call
};

} // namespace hvi::solver
