// The numbering of the time loop: unknowns first, then the eliminated values that are not zero.
#pragma once

#include "solver/fem/space.hpp"

#include <vector>

namespace hvi::solver {

struct Discretisation;
struct Problem;

/// A *state* is a vector of n_state values: [unknowns; imposed values]. Imposed values that are
/// zero at all times are left out, so a problem with zero boundary values has states = unknowns.
struct StateLayout {
  int n_unknowns = 0, n_state = 0, n_dofs = 0;
  std::vector<std::int32_t> dof_of;   ///< of a state entry
  std::vector<std::int32_t> entry_of; ///< of a dof; -1: always zero
  std::vector<DofLink> links;         ///< dofs of periodic parts: `to` has the same entry

  void gather(const Vector& full, Vector& state) const;  ///< resizes nothing
  void scatter(const Vector& state, Vector& full) const; ///< entries without state become 0
};
StateLayout make_layout(const Space& space, const DofMap& dofs);
/// u0 of the problem, interpolated at the nodes; zero in a static one.
Vector initial_state(const Problem& problem, const Discretisation& discretisation,
                     const StateLayout& layout);

/// Rows: unknowns, columns: state entries, of a matrix on full dofs. Rows and columns of dofs that
/// are one are added up.
SparseMatrix restrict_rows(const SparseMatrix& full, const StateLayout& layout);
/// All rows kept, columns to state entries, added up (the rows of a law's G).
SparseMatrix restrict_columns(const SparseMatrix& full, const StateLayout& layout);

} // namespace hvi::solver
