// The forces by which what holds a part, or a law on it, acts on the body, from consistent nodal
// forces.
//
// With r = sum_j F_j u^(j) + sum_m E_m w_m + G^T W xi - f, which the step makes 0 on the unknowns,
// the support acts on the dof i that it holds with the force r_i, and law l with -(G_l^T W_l xi)_i.
// The component c of a part's reaction is the sum over the component's dofs that conditions on the
// part hold, and over the laws on the part. Shape functions sum to 1, so all reactions and loads
// together are what moves the body, sum_i (M u'')_i over the component: 0 to rounding at rest.
//
// Where the scheme's equation holds what was a step ago (time_scheme.hpp), forces are mixed as it
// mixes them: the reaction is that of the step, not that of its end.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/fields.hpp"

#include <optional>
#include <span>
#include <vector>

namespace hvi::solver {

/// The reactions that probes ask for (Probe::Kind::reaction).
class ReactionForces {
public:
  ReactionForces(const Problem& problem, const Discretisation& discretisation, const RunState& run,
                 std::span<const Probe> probes);

  /// Fields that they are made of (slot::field numbering).
  std::vector<bool> fields() const;
  /// Are forces of the step before a part of them?
  bool look_back() const { return scheme_.looks_back(); }
  /// That of probe i at the end of a step; `before`: of the step before it, if they look back.
  double value(int i, const Snapshot& now, const Snapshot& before);
  /// What errors of the reactions of an unknown are compared with, since each may be 0 by symmetry:
  /// the sum of |nodal forces|, of those on the dofs that its reactions are made of, of those of
  /// laws, and of the loads. Assembles matrices.
  double scale(int unknown, const Snapshot& now, const Snapshot& before);
  /// The problem has other loads than before.
  void take_loads();

private:
  /// A few entries of a vector: sum_k weight[k] v[at[k]].
  struct Row {
    std::vector<int> at;
    std::vector<double> weight;
    void add(int entry, double by) { at.push_back(entry), weight.push_back(by); }
    double operator()(const Vector& v) const;
  };
  struct Reaction {
    int unknown = 0;
    std::vector<int> held; ///< dofs
    Row multipliers;       ///< of xi: the supports' share and that of the laws
  };
  /// Of the matrices of the forms, which may be those of states.
  struct FormRows {
    Vector states;
    std::vector<std::vector<Row>> of; ///< by reaction and field
  };
  void add_supports(const Reaction& of, std::vector<double>& of_rows) const;
  void add_laws(const Probe& probe, std::vector<double>& of_rows) const;
  FormRows rows_with(const Vector& states) const;
  void take_states(const Snapshot& now, const Snapshot& before);
  SparseMatrix matrix_at(int field, const Vector& states) const;
  void add_nodal(const Snapshot& at, bool past, Vector& of_fields, Vector& of_laws) const;
  double forces(std::size_t reaction, const Snapshot& at, bool past) const;
  const Vector& load(const Snapshot& now, const Snapshot& before);

  const Problem& problem_;
  const Discretisation& d_;
  const Contact& contact_;
  const TimeScheme& scheme_;
  bool changes_;
  std::optional<LoadAssembler> loads_; ///< where there are reactions
  StateLoads state_loads_;
  SparseMatrix load_transfer_;
  std::vector<int> index_; ///< by probe; -1: it is no reaction
  std::vector<Reaction> reactions_;
  FormRows rows_, past_rows_; ///< the second ones where states change forms and the step looks back
  Vector load_;
  int load_step_ = -1; ///< whose load that is
};

/// Reactions that cannot be had: nothing holds the part, or a law or a condition is on a piece of
/// it.
std::vector<Failure> reactions_of_nothing(const Plan& plan, const Discretisation& discretisation);

} // namespace hvi::solver
