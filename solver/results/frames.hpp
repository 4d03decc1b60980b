// Everything about a moment of a run that is shown: fields of the body and of the contact, and the
// points of laws with the forces there and their branches.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/results/field_grids.hpp"

#include <span>
#include <vector>

namespace hvi::solver {

/// The points of a law as vertices: `xi`, `force` = -M^T xi (vector unknowns), `displacement` (the
/// same; of a pair that of its first side) and, where a run is at a step, `branch`.
class LawGrid {
public:
  LawGrid(const Problem& problem, const Discretisation& discretisation, const Contact& contact,
          int law_term);
  /// `run`: null between steps.
  FieldGrid at(const Snapshot& snapshot, const RunState* run);
  std::vector<Expr> expressions() const { return expressions_; }

private:
  const Contact& contact_;
  const LawTerm& term_;
  std::string name_;
  int dim_, n_xi_, law_term_;
  std::vector<Expr> expressions_;
  LawSampler sampler_;
};

/// The branch of every point of a law term at the run's last step.
std::vector<BranchKind> branches_of(const RunState& run, int law_term);

/// Makes frames of some fields and of all or some laws.
class FrameMaker {
public:
  FrameMaker(const Problem& problem, const Discretisation& discretisation, const Contact& contact,
             std::span<const FieldSpec> fields, std::span<const int> law_terms);
  /// The displacement, a field, and the laws whose multipliers it reads: what a picture shows.
  static FrameMaker of_picture(const Problem& problem, const Discretisation& discretisation,
                               const Contact& contact, const FieldSpec& field);

  std::vector<Expr> expressions() const;
  FieldFrame at(const Snapshot& snapshot, const RunState* run);

private:
  FieldGrids fields_;
  std::vector<LawGrid> laws_;
};

} // namespace hvi::solver
