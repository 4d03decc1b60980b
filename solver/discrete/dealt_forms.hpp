// The forms of a problem as they are sent to the processes that assemble them, each on its own
// cells.
#pragma once

#include "solver/common/stream.hpp"
#include "solver/discrete/body_states.hpp"
#include "solver/discrete/inertia.hpp"
#include "solver/discrete/own_cells.hpp"
#include "solver/plan/couplings.hpp"
#include "solver/plan/problem.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

/// A form that reads states, and the same with the initial ones.
struct ChangingTerm {
  FormTerm form, initial;
  StateReading reading;
};

/// Forms that are assembled once, and by form the coefficients in each field.
struct DealtForms {
  std::vector<FormTerm> terms;
  std::vector<Vector> weights;
  Couplings couplings{}; ///< of several unknowns
  int n_fields = 0;
  /// Not among `terms`: those in u'', where nodes lose their mass (inertia.hpp). The base matrix of
  /// their sum comes behind those of `terms`.
  std::vector<FormTerm> inertia{};
  MovedMass moved{};
  /// Those that read states, each with a base matrix of its own, behind all others.
  std::vector<ChangingTerm> changing{};
  std::vector<Vector> weights_of_changing{};
};

/// All but the moved mass, of which each process has rows of its own.
void put_forms(StateWriter& w, const DealtForms& forms);
DealtForms get_forms(StateReader& r);

/// Those of the rows of moved mass that the process has which these entries are of, in its numbers.
void put_moved(StateWriter& w, const MovedMass& moved, const OwnEntries& entries, int n_state);
MovedMass get_moved(StateReader& r, const StateLayout& layout);
/// The state entries that these rows have columns of in process p.
std::vector<std::int32_t> columns_of_moved(const MovedMass& moved, const Space& space,
                                           const StateLayout& layout,
                                           std::span<const std::int32_t> part_of_node, int p);

} // namespace hvi::solver
