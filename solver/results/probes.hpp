// The probes of a report: values at points, integrals, extremes, norms, reactions, combinations of
// those.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/results/law_sampler.hpp"
#include "solver/results/reaction_forces.hpp"
#include "solver/results/space_norm.hpp"

#include <optional>
#include <variant>

namespace hvi::solver {

class ProbeSet {
public:
  ProbeSet(const Problem& problem, std::vector<Probe> probes, const Discretisation& discretisation,
           const RunState& run);

  int size() const { return static_cast<int>(probes_.size()); }
  /// The problem has other loads than before.
  void take_loads() { reactions_.take_loads(); }
  /// Expressions the probes read fields from (u itself for norms, what reactions are made of).
  std::vector<Expr> expressions() const;
  /// Values at a snapshot into `values`; probes with a time of their own keep what stands there,
  /// combinations are formed from what then stands there. `before`: of the step before, where
  /// they look back.
  void evaluate(const Snapshot& snapshot, const Snapshot& before, std::span<double> values);
  /// Before the first step. `balance`: forces are known, and reactions are.
  void evaluate_start(const Snapshot& snapshot, bool balance, std::span<double> values);
  /// All of them at this snapshot, those with a time of their own, too.
  void evaluate_here(const Snapshot& snapshot, const Snapshot& before, std::span<double> values);
  /// Adds to each floor how much its probe changes when a reaction, of those that it is made of,
  /// changes by the size of the nodal forces (ReactionForces::scale). `values`: as evaluated.
  void add_scales_of_reactions(const Snapshot& snapshot, const Snapshot& before,
                               std::span<const double> values, std::span<double> floors);
  /// The probes with a time in (from, to] (`first`: [from, to]), by index.
  std::vector<int> timed(double from, double to, bool first) const;
  bool any_timed() const;
  /// Does any need the step before?
  bool look_back() const;
  /// Dofs that the probes at points read: those whose shape functions do not vanish there, or all
  /// of the cell where gradients are read.
  std::vector<int> dofs_read() const;
  /// A combination of these values.
  double combined(int i, double t, std::span<const double> values) const;
  /// One probe that is no combination.
  double value(int i, const Snapshot& snapshot, const Snapshot& before);
  /// Is it one that holds for a step, and is not made of the fields of one time?
  bool of_steps(int i) const { return std::holds_alternative<OfSteps>(evaluators_[i]); }

private:
  struct AtPoint {
    int cell;
    std::array<double, 4> barycentric;
    PointValue value;
  };
  struct OnRegion {
    Extreme which;
    int part;
  };
  struct OnLaw {
    Extreme which;
    LawSampler sampler;
  };
  struct OfSteps {}; ///< a reaction
  struct Combination {};
  using Evaluator = std::variant<AtPoint, Integrator, LawSampler, OnRegion, OnLaw, SpaceNorm,
                                 OfSteps, Combination>;

  Evaluator make(const Probe& probe, const Problem& problem, const Discretisation& discretisation,
                 const CellLocator& locator);
  void combine(double t, std::span<double> values) const;

  const Space& space_;
  const std::vector<Region>& parts_;
  const Contact& contact_;
  std::vector<Probe> probes_;
  int n_fields_;
  ReactionForces reactions_;
  std::vector<Evaluator> evaluators_;
  std::vector<double> room_; ///< within a call
};

} // namespace hvi::solver
