// A step's state of least energy (least_state.cpp).
#pragma once

#include "solver/inequality/point_curve.hpp"
#include "solver/inequality/release.hpp"

#include <functional>

namespace hvi::solver {

class LeastState {
public:
  LeastState(PointCurve& curve, ComponentSearch& components, double tolerance)
      : curve_(curve), components_(components), tolerance_(tolerance) {}
  /// The best of the solutions near the states that the bounds of least_energy.hpp suggest, with
  /// the bound. `b`: the arguments of the free body, `free` its displacements.
  void descend(StepAnswer& step, const Vector& b, const Vector& free);
  /// Every solution on the curve through the last state, however often it turns, against the best
  /// of those that were found without it. `settle_on` makes one the step's answer.
  void along_curve(StepAnswer& step, const Vector& b, const Vector& free,
                   const std::function<bool(const CurveSolution&)>& settle_on);

private:
  Vector reach(StepAnswer& step, const Vector& force, const Vector& free, InequalityState& found);

  PointCurve& curve_;
  ComponentSearch& components_;
  double tolerance_;
};

} // namespace hvi::solver
