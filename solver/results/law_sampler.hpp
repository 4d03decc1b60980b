// Expressions that read multipliers or states, at the points where these live: quadrature points of
// laws, and of bodies.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/fem/pointwise.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/fields.hpp"

#include <map>
#include <optional>
#include <set>
#include <vector>

namespace hvi::solver {

/// Expressions of x, t, normal, fields, multipliers and states at the points of the first one of
/// the last two that they read (of the first that lives on the part, if one is given). States of
/// bodies may be read behind the membership in their parts, and count as 0 elsewhere. On facets and
/// at points a state of a body is that of its point nearest by in the cell behind the facet, where
/// gradients are read, too; on the other side of a facet within the mesh where it lives there only:
/// all is read there then. The weights
/// are the law's quadrature weights *without* the factor before the law: xi is in dj, and the
/// factor stands outside. Multipliers of other terms must have their points at the same places
/// (normal law and friction on one part do).
class LawSampler {
public:
  /// On the law's part (part = -1), or on another part whose points are among the law's: the law's
  /// rule is set up there, on facets that read a body's states Gauss's rule. Expressions that read
  /// neither multiplier nor state: at the points of a pair. Throws Failure(bad_value) when a point
  /// has no multiplier.
  LawSampler(const Problem& problem, const Discretisation& discretisation, const Contact& contact,
             std::vector<Expr> expressions, Origin origin, int part = -1);
  /// At one place: the law's points there, of a law on several parts those of the first part that
  /// has the place, or those of a body's cells there, weights adding up to 1. Nothing: what it
  /// reads lives elsewhere, and the expression does not need it there.
  static std::optional<LawSampler> at(const Problem& problem, const Discretisation& discretisation,
                                      const Contact& contact, const Expr& expression, Origin origin,
                                      const Point& place);
  /// A probe of jumps: at its place on its pair, or on the pair that has the place.
  static LawSampler at_pair(const Problem& problem, const Discretisation& discretisation,
                            const Contact& contact, const Probe& probe);

  int size() const { return static_cast<int>(block_.size()); }
  const PointBlock& points() const { return block_; }
  const std::vector<std::int32_t>& nodes() const { return nodes_; } ///< -1 where not nodal
  int part() const { return part_; }                                ///< where these points are
  bool in_body() const { return in_body_; } ///< they are those of a state in cells
  /// out[e * size + p]: expression e at point p.
  void evaluate(const Contact& contact, const Snapshot& snapshot, std::span<double> out);
  /// sum_p weight_p expression(p), of the first expression.
  double integral(const Contact& contact, const Snapshot& snapshot);

private:
  /// Without points.
  LawSampler(const Problem& problem, const Contact& contact, std::vector<Expr> expressions,
             Origin origin);
  void take_points(const LawPoints& points, const LawTerm& term, const std::vector<int>& chosen);
  void go_to_cells(const Mesh& mesh, const LawPoints& body);
  void match(const Contact& contact, int place, int dim);
  int match_in_cell(const Contact& contact, int place, std::size_t p) const;
  [[noreturn]] void refuse(const Contact& contact, int place, std::size_t p, int dim) const;
  void match_all(const Discretisation& discretisation, const Contact& contact);
  void take_place(const Discretisation& discretisation, const Contact& contact,
                  const LawPoints& points, const LawTerm& term, const Point& place,
                  const std::string& help);
  void prepare_field(const Space& space, Slot slot);

  Pointwise expressions_;
  Origin origin_;
  int place_ = -1, part_ = -1;
  bool in_body_ = false;
  std::set<int> guarded_; ///< places whose states stand behind the membership in their parts
  PointBlock block_;
  std::vector<std::int32_t> nodes_;
  std::map<int, std::vector<int>> point_of_; ///< by place: its point at each of ours
  std::map<Slot, SparseMatrix> rows_;        ///< by field slot: points x dofs
  std::map<Slot, Vector> columns_;           ///< values of the slots that change
  std::vector<double> values_;
};

/// The parts of the bodies whose states an expression reads, where there are several.
std::vector<int> parts_of_states(const Problem& problem, const Contact& contact,
                                 std::span<const Expr> expressions);
/// Expressions as they are on each part where all laws act whose multipliers they read, in the
/// order of the law terms; as they are written where there is no such part.
std::vector<std::vector<Expr>> on_parts_of_laws(const Problem& problem,
                                                std::span<const Expr> expressions);
/// Do they read nothing that lives at the points of a law?
bool lives_in_bodies(const Contact& contact, std::span<const Expr> expressions);
/// An expression away from the parts of all the states that it reads.
Expr away_from_states(const Problem& problem, Expr expression);

/// The probes and fields of a report that ask for multipliers where there are none.
std::vector<Failure> misplaced_multipliers(const Plan& plan, const Discretisation& discretisation);

} // namespace hvi::solver
