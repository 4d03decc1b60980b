// The energy that bodies and laws store.
//
//   elastic = <B u, u>/2,   contact = sum_p w_p j(z_p) of the laws on u,   load = <f, u>
//
// on full vectors, with a matrix B of its own, so that it also checks the steps, or by the halves
// of the base matrices where they alone are kept. elastic + contact - load is what a stable state
// makes least.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/step/run_state.hpp"

namespace hvi::solver {

class StoredEnergy {
public:
  /// `own`: a matrix B of its own in any case.
  StoredEnergy(const Problem& problem, const Discretisation& discretisation, const RunState& run,
               bool own = true);

  /// Is it what a state of rest makes least? B is symmetric, nothing moves, and no law reads the
  /// solution or a multiplier, as Coulomb's bound does.
  bool is_least_at_rest() const { return symmetric_ && potentials_ && !moves_; }
  /// Of the run's state: elastic + contact - load.
  double energy(const RunState& run);
  /// B where states change it.
  void take_states(const RunState& run);

  const SparseMatrix& matrix() const { return elastic_; }                     ///< B on all dofs
  double elastic(const Vector& u) const { return 0.5 * u.dot(elastic_ * u); } ///< by that
  /// With the laws and offsets of the run's time.
  double contact(const RunState& run, const Vector& u);
  /// f of the run's time, on all dofs.
  void load(const RunState& run, Vector& out) const;

private:
  static double elastic_by_products(const RunState& run);

  const Problem& problem_;
  const Discretisation& d_;
  bool own_;
  SparseMatrix elastic_;
  SparseMatrix load_transfer_; ///< of loads to where the mass is (inertia.hpp)
  LoadAssembler loads_;
  StateLoads state_loads_; ///< with the states at the end of a step
  bool symmetric_, potentials_, moves_;
  Vector z_; ///< arguments of laws
};

} // namespace hvi::solver
