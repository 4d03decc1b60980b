// The equilibrium curve of the reduced inequality between two loads.
//
// With S invertible, (*) of inequality.hpp is a problem on the laws' arguments alone,
//
//     z + C W xi = b(l),   xi_p in dj_p(z_p),   C = G S^-1 G^T,   b(l) = b_0 + l (b_1 - b_0),
//
// l = 0 the last state, l = 1 the one that is looked for. With the graph's jumps filled in, its
// solutions (z, xi, l) form a curve. For laws of straight pieces it is a chain of straight
// segments, each found exactly: one linear solve, then on to the first point that leaves its piece
// (J. Katzenelson, An algorithm for solving nonlinear resistor networks, 1965; T. Fujisawa and
// E. S. Kuh, Piecewise-linear theory of nonlinear networks, 1970). Curved pieces are followed by
// steps along the tangent with Newton corrections (pseudo-arclength; H. B. Keller, Numerical
// solution of bifurcation and nonlinear eigenvalue problems, 1977).
//
// While l grows along the curve its states are stable (S + H positive definite; det changes sign
// where the curve turns). Where it turns back the branch has ended: a limit point. The state after
// the jump is the next one that the curve has at the same load and that is stable again.
#pragma once

#include "solver/inequality/curve_state.hpp"

#include <functional>

namespace hvi::solver {

class CurveWalk;

/// The branch that continues a state, with the jumps to others where branches ended.
struct FollowedBranch {
  bool arrived = false; ///< at l = 1 and stable; else the curve has no stable state to go on from
  CurveState state;     ///< at l = 1, where it arrived
  std::vector<double> ends; ///< the loads at which branches ended
  int steps = 0;            ///< CurveWalk::steps
};

class EquilibriumCurve {
public:
  /// As CurveProblem.
  EquilibriumCurve(DenseMatrix compliance, std::vector<CurvePoint> points);
  const DenseMatrix& compliance() const { return problem_.compliance; }

  /// From the state (z, xi), which is an equilibrium by the choice of b_0 = z + C W xi (xi is put
  /// on the graph first), to l = 1, where b = b_1.
  FollowedBranch follow(const Vector& z, const Vector& xi, const Vector& b1) const;
  /// Along the whole curve, both ways, however often it turns: `solution` is called at each l = 1.
  /// Returns the steps of both ways.
  int visit(const Vector& z, const Vector& xi, const Vector& b1,
            const std::function<void(const CurveState&)>& solution) const;

private:
  bool stable(const CurveState& at) const;
  bool jump_at(double load, CurveWalk& walk) const;
  bool arrive(CurveWalk& walk, std::vector<double>& ends) const;

  CurveProblem problem_;
  DenseMatrix root_; ///< L with C = L L^T
};

} // namespace hvi::solver
