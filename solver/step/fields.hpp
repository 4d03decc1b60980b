// Full vectors of u, u' and the history fields, as far as a report reads them.
#pragma once

#include "solver/assembly/assembly.hpp"
#include "solver/step/run_state.hpp"

#include <vector>

namespace hvi::solver {

/// The fields at one time as FieldValues wants them; absent ones are empty.
class Snapshot {
public:
  Snapshot() = default;
  Snapshot(std::vector<bool> needed, int n_dofs, int n_rows);

  /// The run's current state.
  void take(const RunState& run) { take(run, true); }
  /// Not `whole`: contact unknowns and observed dofs only, where states hold nothing else.
  void take(const RunState& run, bool whole);
  /// The initial state before the first step: what is not known there is NaN.
  void take_start(const RunState& run, const Problem& problem, const Space& space);
  /// Adds `step` times the error to all fields and multipliers.
  void move(const ErrorSample& error, double step);
  /// this = (1 - theta) a + theta b: the piecewise affine interpolant between grid times. What is
  /// not known at the initial time, where `a` is that, is b's in the whole step (0 < theta).
  void interpolate(const Snapshot& a, const Snapshot& b, double theta);

  FieldValues values() const { return {pointers_, t_}; }
  double t() const { return t_; }
  int step() const { return step_; }
  const Vector& field(int k) const { return fields_[k]; }
  const Vector& xi() const { return xi_; }
  const Vector& states() const { return states_; } ///< as Contact::state_values

  Snapshot(const Snapshot& other);
  Snapshot& operator=(const Snapshot& other);

private:
  void point();

  std::vector<bool> needed_;
  std::vector<Vector> fields_;
  std::vector<const Vector*> pointers_;
  Vector xi_, states_, state_;
  double t_ = 0.0;
  int step_ = 0;
};

} // namespace hvi::solver
