// Fields on the grids they live on, filled from snapshots: for files, pictures and viewers.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/output/field_frame.hpp"
#include "solver/results/state_field.hpp"

#include <array>
#include <span>

namespace hvi::solver {

/// Body fields share one grid: point data for expressions of values, cell averages for expressions
/// with gradients. A multiplier has a grid of its own on the contact part: its facets with point
/// data when the law's rule is nodal, else the quadrature points.
class FieldGrids {
public:
  /// Fields that read states of bodies: each part of the states has a grid of its own, or they are
  /// cell data of the body's grid.
  enum class OfStates : std::uint8_t { by_parts, on_the_mesh };
  FieldGrids(const Problem& problem, const Discretisation& discretisation, const Contact& contact,
             std::span<const FieldSpec> fields, OfStates of_states = OfStates::by_parts);

  std::vector<Expr> expressions() const;
  /// The body's grid first, where there are fields of the body; until the next call.
  const std::vector<FieldGrid>& fill(const Snapshot& snapshot);

private:
  struct OnContact {
    FieldSpec field;
    LawSampler sampler;
    std::vector<std::int64_t> grid_point; ///< of each point of the sampler; in a body: its cell
    /// Grid points where the sampler has no weight, each with those beside it where it has.
    std::vector<std::array<std::int64_t, 2>> beside{};
  };
  void add_parts(const Problem& problem, const Discretisation& d, const FieldSpec& field);
  void add_on_contact(const Problem& problem, const Discretisation& d, const FieldSpec& field,
                      int on, const std::string& name);
  void add_body_array(const FieldSpec& field, const Snapshot& snapshot);
  void refuse_outside_tables(const FieldSpec& field, bool on_cells, std::span<const double> values,
                             const Snapshot& snapshot) const;
  void add_state_array(StateField& one, const Snapshot& snapshot);
  void fill_contact(OnContact& part, VtuGrid& grid, const Snapshot& snapshot) const;

  const Space& space_;
  const Contact& contact_;
  int n_fields_;
  bool grey_; ///< what has no value is NaN, for pictures; files have 0 there
  std::vector<FieldSpec> body_;
  std::vector<StateField> of_states_; ///< on the mesh
  std::vector<OnContact> contact_parts_;
  std::vector<FieldGrid> grids_;
};

/// The grid of the body: P1 or P2 cells in VTK's order of nodes.
VtuGrid body_grid(const Space& space);

/// Every unknown as a field; the first vector is called displacement_array.
std::vector<FieldSpec> unknown_fields(const Problem& problem, int dim);

} // namespace hvi::solver
