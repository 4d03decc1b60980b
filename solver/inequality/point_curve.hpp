// The equilibrium curve (equilibrium_curve.hpp) of the points of a reduced problem: the body is its
// compliance at the points, C = G S^-1 G^T.
#pragma once

#include "solver/inequality/equilibrium_curve.hpp"
#include "solver/inequality/step_start.hpp"

#include <optional>

namespace hvi::solver {

/// A solution that the curve found; c from S c = r - G^T W xi.
struct CurveSolution {
  Vector c, z, xi;
  std::vector<int> places;
};

class PointCurve {
public:
  explicit PointCurve(const ContactPoints& points) : points_(points) {}
  /// With S factored by `s`, once for S. False: too large, a vector law, or no energy that says
  /// which states are stable.
  bool prepare(const ReducedOperator& s);
  const EquilibriumCurve& curve() const { return *curve_; }
  std::vector<CurvePoint> curve_points() const;

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
  std::optional<DenseMatrix> compliance(const ReducedOperator& s);

  const ContactPoints& points_;
  std::vector<CurveGraph> graphs_; ///< by prepared law
  std::optional<EquilibriumCurve> curve_;
  DenseMatrix response_; ///< S^-1 G^T
};

} // namespace hvi::solver
