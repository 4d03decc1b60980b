// A walk along the equilibrium curve, one step after the other.
#pragma once

#include "solver/inequality/curve_equations.hpp"

#include <algorithm>

namespace hvi::solver {

/// How a step ended.
enum class CurveStep {
  crossed, ///< where a point goes on to the next place of its graph
  at_load, ///< at the load that was asked for
  moved,   ///< somewhere on curved pieces
  failed
};

struct CurvePosition {
  CurveState state;
  CurveTangent tangent; ///< the way the walk goes on
  bool load_rises() const { return tangent.load > 0.0; }
};

/// A walk gives up after so many steps. Between a state that a branch lost and the next stable one
/// the curve of a body that peels may fold thousands of times; a step solves a dense system, so
/// that few points may take more of them.
constexpr int most_curve_steps(int points) {
  return std::max(2000 + 100 * points, 50000 - 500 * points);
}

class CurveWalk {
public:
  CurveWalk(CurveEquations equations, CurveState start)
      : equations_(std::move(equations)), now_{std::move(start), {}} {}
  /// Finds the first tangent, along which the load rises. False: there is none.
  bool begin();
  void reverse() { now_.tangent.reverse(); }

  /// To the end of what is straight, to the load `target`, or on curved pieces as far as the
  /// tangent serves. After `failed` the position is of no use.
  CurveStep step(double target);
  /// The load rose before the last step, which began here, and falls after it: to where it turns.
  void find_turn(const CurvePosition& before);

  const CurvePosition& here() const { return now_; }
  int steps() const { return steps_; } ///< segments, steps on curved pieces, turns at corners
  bool may_go_on() const { return steps_ < most_curve_steps(equations_.problem().size()); }

private:
  CurveStep step_on_curved(double length, double target);
  bool go(double length);
  bool keeps_direction(const CurveTangent& before, bool first_try);

  CurveEquations equations_;
  CurvePosition now_;
  double stride_ = 0.05; ///< the next step on curved pieces moves no point by more of the size
  int steps_ = 0;
};

/// From the state (z, xi) towards the load b1. The curve is the one through that state: xi is put
/// on the graph first, then b_0 = z + C W xi.
CurveWalk walk_from(const CurveProblem& problem, const Vector& z, const Vector& xi,
                    const Vector& b1);

} // namespace hvi::solver
