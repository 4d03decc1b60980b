// The load in the equation of a step.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/time_scheme.hpp"
#include "solver/formulation/formulation.hpp"

namespace hvi::solver {

/// Adds present(0) f_n + past(0) f_{n-1} to `out`, f_n = f(t_n) or the mean over step n; f_0 =
/// f(t_0). The mean over a step is what `midpoint` averages two ends for.
void add_step_load(const LoadAssembler& loads, const TimeSpec& time, const TimeScheme& scheme,
                   int n, Vector& out);

/// The loads of a run's steps, on the unknowns, with what the equation holds of the step before.
class StepLoad {
public:
  /// Keeps references to all but the discretisation.
  StepLoad(const Problem& problem, const Discretisation& discretisation,
           const Formulation& formulation, const TimeScheme& scheme);

  /// out = f_n, or its mean over the step; loads that read states have those at hand.
  void find(int n, Vector& out) const;
  /// xi_{n-1} of the next step, n.
  void note_multipliers(const Vector& xi);
  /// What the equation of the next step has of forms at t_{n-1} whose matrices change.
  void note_forces(const Vector& forces) { last_forces_ = forces; }
  /// The same of loads that read states: those of step n - 1 with the states at hand.
  void note_state_loads(int n);

private:
  bool keeps_reactions() const;
  void add_state_loads(int n, double factor, Vector& out) const;

  const Problem& problem_;
  const Formulation& formulation_;
  const TimeScheme& scheme_;
  SparseMatrix transfer_;  ///< on the unknowns (inertia.hpp); without entries: none
  Vector last_reaction_;   ///< G^T W xi_{n-1}, where the scheme asks for it
  Vector last_forces_;     ///< empty: there are none
  Vector last_state_load_; ///< the same
};

} // namespace hvi::solver
