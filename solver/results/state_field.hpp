// Fields that read states of bodies, over the whole mesh: for pictures, reports and arrays. Files
// have them part by part (field_grids.hpp).
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/results/law_sampler.hpp"

#include <vector>

namespace hvi::solver {

class StateField {
public:
  /// Does the field read states of bodies, and nothing of the points of laws?
  static bool is_one(const Problem& problem, const Contact& contact, const FieldSpec& field);
  /// Keeps references to d and contact.
  StateField(const Problem& problem, const Discretisation& d, const Contact& contact,
             const FieldSpec& field);

  const FieldSpec& field() const { return field_; }
  /// The means over the cells, components of a cell side by side. Away from the parts of the
  /// states: what the field is there, NaN where it is nothing without them.
  std::vector<double> of_cells(const Snapshot& snapshot);
  /// The means of the cells around the nodes of the space, by their measure: of those with a value.
  std::vector<double> of_nodes(const Snapshot& snapshot);

private:
  const Discretisation& d_;
  const Contact& contact_;
  FieldSpec field_;
  std::vector<LawSampler> on_parts_;
  std::vector<Expr> elsewhere_; ///< none: it is nothing there
};

} // namespace hvi::solver
