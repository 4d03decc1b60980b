// Energies and the quantities of the a priori estimate, step by step: on request, beside the run.
//
// Everything is computed on full vectors with matrices of its own, so it also checks the steps.
// With d = u_n - u_{n-1}, f_n the load, r_n the reaction on imposed values, W the laws' weights:
//   work     += <f_n + r_n, d>         elastic = <B u_n, u_n>/2     contact = sum_p w_p j(z_p)
//   viscous  += <A u'_n, d>            memory += <sum_m E_m w_m, d>  kinetic = <M v_n, v_n>/2
//   lost     += work - viscous - memory - (change of elastic + contact + kinetic)
//   friction += <G^T W xi, d> of each law on u' or on a memory, which stores nothing: a part of
//   `lost`
//   released: what states take from the potentials of laws and forms (released_energy.hpp), as well
//   energy    = elastic + contact - <f_n, u_n>: what a stable state makes least, and kinetic
// Forces are those of the scheme's equation (time_scheme.hpp); with `newmark` the means of t_n and
// t_{n-1}, so that what it loses while nothing touches is rounding.
// `lost` is that friction, what is released, the dissipation of the scheme, <B d, d>/2 to first
// order, and what snaps set free. Lemma 3.2 bounds, independent of the step k (V: the norm of
// eps(u); X: L2 with the laws' weights)
//   max |u_n|_V,   sum |u_n - u_{n-1}|_V^2,   max |xi_n|_X*,   sum k |(u_n - u_{n-1})/k|_V^2.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/results/released_energy.hpp"
#include "solver/results/stored_energy.hpp"

#include <array>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace hvi::solver {

/// Is a column of the monitors an energy, or a part of one?
bool is_energy(std::string_view column);

class EnergyMonitor {
public:
  /// The run stands at its initial state.
  EnergyMonitor(const Problem& problem, const Discretisation& discretisation, const RunState& run);

  /// Takes an accepted step. `outcome`: its certificate and iterations go into the columns.
  void take(const RunState& run, const StepResult& outcome);
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::vector<double>>& columns() const { return columns_; }
  /// The worst |work identity| of a step by the largest sum of its parts' sizes: rounding.
  double balance_error() const { return largest_size_ > 0 ? largest_error_ / largest_size_ : 0.0; }

  void save(std::ostream& out) const;
  /// `run`: restored already.
  void restore(std::istream& in, std::size_t rows, const RunState& run);

private:
  double norm_squared(const Vector& v) const { return v.dot(gram_ * v); }
  void take_states(const RunState& run);
  double kinetic_energy(const RunState& run);
  void add_friction(const RunState& run);
  /// What does work in a step: vectors on all dofs.
  struct Forces {
    Vector inertia, viscous, elastic, memory, contact, load;
  };
  static constexpr std::array all_forces{&Forces::inertia, &Forces::viscous, &Forces::elastic,
                                         &Forces::memory,  &Forces::contact, &Forces::load};
  void forces(const RunState& run);
  void take_forces(const RunState& run);
  double reaction_work(const Forces& acting);
  void add_sums(const RunState& run, const Forces& acting, double reaction);
  void mix(Vector Forces::*force, double present, double past);
  void mix_steps(const TimeScheme& scheme);

  const Problem& problem_;
  const Discretisation& d_;
  StoredEnergy stored_;
  SparseMatrix inertia_, rate_, gram_; ///< M, A, the Gram matrix of V on all dofs
  std::vector<SparseMatrix> memory_;   ///< E_m
  ReleasedEnergy released_;            ///< by states

  Vector u_, before_, d_u_, work_, state_; ///< full vectors
  Forces now_, last_, acting_;             ///< at t_n, at t_{n-1}; what the step's equation has
  bool moves_, looks_back_;                ///< is there inertia; do earlier forces act in a step
  double energy_scale_ = 1.0;              ///< the equation was divided by it
  Vector acting_xi_, last_xi_;             ///< multipliers as forces are
  double elastic_energy_ = 0, contact_energy_ = 0, kinetic_energy_ = 0, largest_error_ = 0,
         largest_size_ = 0;
  std::vector<std::string> names_;
  std::vector<double> sums_; ///< work, viscous, memory, lost, and the four of Lemma 3.2
  std::vector<double>
      friction_; ///< so far, of every law that is not on u, in the order of the terms
  std::vector<std::vector<double>> columns_;
};

} // namespace hvi::solver
