// Expressions at many points: quadrature points of a region in blocks, and tapes run over them.
#pragma once

#include "solver/fem/geometry.hpp"
#include "solver/kernel/tape.hpp"

#include <functional>
#include <map>

namespace hvi::solver {

/// Quadrature points, structure of arrays, entity by entity.
struct PointBlock {
  std::array<std::vector<double>, 3> x, normal; ///< normal: 0 inside cells and at point regions
  std::vector<double> weight;                   ///< quadrature weight times measure of the entity
  std::vector<std::int32_t> cell;               ///< a cell the point lies in
  std::vector<std::int32_t> entity;             ///< cell, facet or node it was made from
  std::vector<Barycentric> barycentric;         ///< in `cell`
  Group::Kind kind = Group::Kind::cells;        ///< of the entities
  std::vector<double> gap;                      ///< points of a pair: slot::gap
  /// Points of a pair: the value of a field is the jump of it, row pair_point[p] of `jump`, which
  /// has the means behind (pairing.hpp).
  std::shared_ptr<const SparseMatrix> jump;
  std::vector<std::int32_t> pair_point;
  std::shared_ptr<const PartIndicators> indicators; ///< for slot::inside
  std::size_t size() const { return weight.size(); }
  void clear();
  Point point(std::size_t p) const { return {x[0][p], x[1][p], x[2][p]}; }
};

/// The quadrature points of a region, made on demand block by block. A point region has one point
/// per node, with weight 1.
///
/// On axisymmetric meshes all weights carry 2 pi x, here and in pairing.cpp only: cells stand for
/// rings, facets for surfaces and points for circles of revolution (a point on the axis for itself,
/// with weight 1). `exact` and `gauss` are then of a higher degree: by 1 for the weight, and for
/// vectors by 2 more for products with u_x/x, which are rational. `nodal` has the weights int phi_i
/// 2 pi x of weighted_nodal_rule.
class RegionPoints {
public:
  /// `order`: of the nodes of the rule `nodal`; 0: the space's.
  RegionPoints(const Space& space, const Region& region, Rule rule, int exact_degree,
               int order = 0);
  /// For means: the weights do not carry 2 pi x.
  RegionPoints(const Space& space, const Region& region, Quadrature rule);
  std::size_t entities() const { return entities_.size(); }
  std::size_t per_entity() const { return rule_.size(); }
  /// Entities [first, last) of the region's list, replacing the block's contents.
  void fill(std::size_t first, std::size_t last, PointBlock& block) const;
  /// Calls f(block) for the whole region, a few hundred points at a time.
  void for_blocks(const std::function<void(const PointBlock&)>& f) const;

private:
  /// The entity as a simplex on some corners of its cell.
  struct Simplex {
    double measure = 1.0;
    Point normal{};
    std::array<int, 4> corners{0, 1, 2, 3};
    int n_corners = 1;
  };
  Simplex simplex(std::size_t e) const;
  /// Weights of the rule on this entity.
  void weigh(std::size_t e, const Simplex& entity, std::vector<double>& out) const;

  enum class Ring { none, by_point, by_node };

  const Mesh* mesh_;
  std::shared_ptr<const PartIndicators> indicators_;
  Group::Kind kind_;
  std::vector<std::int32_t> entities_, cells_; ///< cells_: the cell of each entity
  Quadrature rule_;
  Ring ring_ = Ring::none;
  int order_ = 1;
};

/// Dimension of the entities of a region.
int dimension_of(const Mesh& mesh, const Region& region);

/// A group of expressions compiled together.
class Pointwise {
public:
  explicit Pointwise(std::span<const Expr> expressions);
  /// column(slot) points to n values of that slot; nullptr: the slot has no meaning here.
  using Columns = std::function<const double*(Slot)>;
  /// out[o * n + p]: expression o at point p. Throws Failure(bad_value) where a column is missing.
  void evaluate(std::size_t n, const Columns& columns, Origin origin, std::span<double> out);
  /// At a block's points: x, normal, t and the indicators of parts; `more` for other slots.
  void evaluate(const PointBlock& block, double t, Origin origin, std::span<double> out,
                const Columns& more = {});
  const std::vector<Slot>& inputs() const { return tape_.inputs; }

private:
  const double* inside_column(const PointBlock& block, Slot slot);

  Tape tape_;
  TapeWorkspace workspace_;
  std::vector<const double*> pointers_;
  std::vector<double> time_;
  std::map<Slot, std::vector<double>> inside_;
};

/// "u_x'", "normal", ... for messages about a slot.
std::string describe_slot(Slot slot);
/// Throws Failure(bad_value): "`what` is nan at (0.5, 1), t = 0.2"; t only when it is given.
[[noreturn]] void throw_not_finite(Origin origin, const std::string& what, double value,
                                   const Point& point, int dim, const double* t = nullptr);

} // namespace hvi::solver
