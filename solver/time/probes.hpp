// The probes of a report: values at points, integrals, norms, combinations of those.
#pragma once

#include "solver/linear/symmetric_blocks.hpp"
#include "solver/time/law_sampler.hpp"
#include "solver/time/run_state.hpp"

#include <variant>

namespace hvi::solver {

class ProbeSet {
public:
  ProbeSet(const Plan& plan, const Discretisation& discretisation, const RunState& run);

  int size() const { return static_cast<int>(probes_.size()); }
  /// Expressions the probes read fields from (u itself for norms).
  std::vector<Expr> expressions() const;
  /// Values at a snapshot into `values`; probes with a time of their own keep what stands there,
  /// combinations are formed from what then stands there.
  void evaluate(const Snapshot& snapshot, std::span<double> values);
  /// All of them at this snapshot, those with a time of their own, too.
  void evaluate_here(const Snapshot& snapshot, std::span<double> values);
  /// The probes with a time in (from, to] (`first`: [from, to]), by index.
  std::vector<int> timed(double from, double to, bool first) const;
  bool any_timed() const;
  /// Dofs that the probes at points read: those whose shape functions do not vanish there, or all
  /// of the cell where gradients are read.
  std::vector<int> dofs_read() const;
  /// One probe that is no combination.
  double value(int i, const Snapshot& snapshot);

private:
  struct AtPoint {
    int cell;
    std::array<double, 4> barycentric;
    PointValue value;
  };
  struct NormV {
    int unknown;
  };
  struct Combination {};
  using Evaluator = std::variant<AtPoint, Integrator, LawSampler, NormV, Combination>;

  Evaluator make(const Probe& probe, const Problem& problem, const Discretisation& discretisation,
                 const RunState& run, const CellLocator& locator);
  void make_gram(const Discretisation& discretisation, const RunState& run, int unknown);
  double norm(const Vector& u, int unknown);
  void combine(double t, std::span<double> values) const;

  const Space& space_;
  const StateLayout& layout_;
  const Contact& contact_;
  std::vector<Probe> probes_;
  int n_fields_;
  std::vector<Evaluator> evaluators_;
  struct Gram {
    SymmetricBlocks matrix;
    bool on_states = false;
  };
  std::vector<Gram> grams_; ///< by unknown, of its space, when a norm asks for it
  Vector state_;            ///< u, where a Gram matrix is one of states; else empty
};

} // namespace hvi::solver
