// The equilibrium curve (equilibrium_curve.hpp) of the points of a reduced problem: the body is its
// compliance at the points, C = G S^-1 G^T. Points whose argument no unknown moves, at nodes with
// imposed values, act on nothing that is solved for: the curve leaves them out.
#pragma once

#include "solver/inequality/equilibrium_curve.hpp"
#include "solver/inequality/step_start.hpp"

#include <optional>

namespace hvi::solver {

/// A solution that the curve found, by its points; c from S c = r - G^T W xi.
struct CurveSolution {
  Vector c, z, xi;
  std::vector<int> places;
};

class PointCurve {
public:
  explicit PointCurve(const ContactPoints& points) : points_(points) {}
  /// Is there a curve for the body S? Not of too many points, of vector laws, nor where no energy
  /// says which states are stable.
  bool serves(const ReducedOperator& s) const;
  /// Where it serves, with S factored by `s`. False: no point moves, or S is all but singular.
  /// `before_solve`: called before each of the solves with S, one a point.
  bool prepare(const ReducedOperator& s, const std::function<void()>& before_solve);
  const EquilibriumCurve& curve() const { return *curve_; }
  std::vector<CurvePoint> curve_points() const;
  /// Of rows of all points, those of the curve's.
  Vector on_curve(const Vector& rows) const;
  /// Forces at the curve's points from multipliers, and multipliers from forces (others: zero).
  Vector forces(const Vector& xi) const;
  Vector multipliers(const Vector& force) const;

  /// Where the curve begins: the last state's arguments, those that rest exactly on their breaks.
  Vector start(const StepStart& start) const;
  /// A state of the curve with its displacements, `free` those of the body without forces.
  CurveSolution solution(const CurveState& at, const Vector& free) const;
  /// The displacements under forces at the points.
  Vector displaced(const Vector& free, const Vector& force) const {
    return free - response_ * force;
  }
  /// Puts a search on a solution of the curve.
  void go(const CurveSolution& to, Position& at) const;

private:
  std::optional<DenseMatrix> compliance(const ReducedOperator& s,
                                        const std::function<void()>& before_solve);

  const ContactPoints& points_;
  std::vector<int> moved_;         ///< the points of the curve
  std::vector<CurveGraph> graphs_; ///< by prepared law
  std::optional<EquilibriumCurve> curve_;
  DenseMatrix response_; ///< S^-1 G^T
};

} // namespace hvi::solver
