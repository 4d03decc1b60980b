// Branches of the equilibrium curve between two loads (equilibrium_curve.hpp).
#include "solver/inequality/equilibrium_curve.hpp"

#include "solver/inequality/curve_walk.hpp"
#include "solver/linear/dense.hpp"

#include <algorithm>

namespace hvi::solver {

namespace {
/// A turn on a curved piece is left for a load this much larger: at the turn itself Newton's method
/// has nothing to go by.
constexpr double beyond_turn = 1e-11;
/// An upright point is held as if by a spring this much stiffer than the body.
constexpr double held_stiffness = 1e9;
} // namespace

EquilibriumCurve::EquilibriumCurve(DenseMatrix compliance, std::vector<CurvePoint> points)
    : problem_(std::move(compliance), std::move(points)) {
  DenseMatrix c = 0.5 * (problem_.compliance + problem_.compliance.transpose());
  c.diagonal().array() += 1e-13 * c.diagonal().maxCoeff();
  root_ = DenseCholesky(c).lower();
}

/// Is S + H positive definite, upright points held? That is the same of 1 + L^T H L.
bool EquilibriumCurve::stable(const CurveState& at) const {
  const int n = problem_.size();
  Vector stiffness(n);
  for (int p = 0; p < n; ++p) {
    if (problem_.falls(at, p)) return false;
    const double weight = problem_.points[p].weight;
    stiffness[p] =
        at.upright(p) ? held_stiffness * weight / problem_.a(p, p) : weight * at.curvature[p];
  }
  DenseMatrix m = root_.transpose() * stiffness.asDiagonal() * root_;
  m.diagonal().array() += 1.0;
  return DenseCholesky(m).positive();
}

/// On along the curve until it is stable at this load again.
bool EquilibriumCurve::jump_at(double load, CurveWalk& walk) const {
  while (walk.may_go_on()) {
    const CurveStep step = walk.step(load);
    if (step == CurveStep::failed) return false;
    if (step == CurveStep::at_load && walk.here().load_rises() && stable(walk.here().state))
      return true;
  }
  return false;
}

/// To l = 1. False: the curve has no further stable state at a load where a branch ended.
bool EquilibriumCurve::arrive(CurveWalk& walk, std::vector<double>& ends) const {
  if (!walk.begin()) return false;
  if (!stable(walk.here().state)) {
    walk.reverse();
    ends.push_back(0.0);
    if (!jump_at(0.0, walk)) return false;
  }
  while (walk.may_go_on()) {
    const CurvePosition before = walk.here();
    const CurveStep step = walk.step(1.0);
    if (step == CurveStep::failed) return false;
    if (step == CurveStep::at_load) return stable(walk.here().state);
    if (walk.here().load_rises()) continue;
    const bool smooth = step == CurveStep::moved;
    if (smooth) walk.find_turn(before);
    const double load = walk.here().state.load;
    ends.push_back(load);
    if (!jump_at(smooth ? std::min(1.0, load + beyond_turn) : load, walk)) return false;
  }
  return false;
}

FollowedBranch EquilibriumCurve::follow(const Vector& z, const Vector& xi, const Vector& b1) const {
  CurveWalk walk = walk_from(problem_, z, xi, b1);
  FollowedBranch out;
  out.arrived = arrive(walk, out.ends);
  out.state = walk.here().state;
  out.steps = walk.steps();
  return out;
}

int EquilibriumCurve::visit(const Vector& z, const Vector& xi, const Vector& b1,
                            const std::function<void(const CurveState&)>& solution) const {
  int steps = 0;
  for (const bool back : {false, true}) {
    CurveWalk walk = walk_from(problem_, z, xi, b1);
    if (!walk.begin()) return 0;
    if (back) walk.reverse();
    while (walk.may_go_on()) {
      const CurveStep step = walk.step(1.0);
      if (step == CurveStep::failed) break;
      if (step == CurveStep::at_load) solution(walk.here().state);
    }
    steps += walk.steps();
  }
  return steps;
}

} // namespace hvi::solver
