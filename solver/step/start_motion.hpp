// How a run with u'' begins.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/plan/plan.hpp"
#include "solver/step/run_state.hpp"

namespace hvi::solver {

/// Sets u'(t_0) in the run's scheme and, where that asks for it, u''(t_0) with the multipliers
/// xi_0:
///
///   M a + A v_0 + B u_0 + G^T W xi_0 = f(t_0),
///   xi_0 in dj(z_0), of all such the one with the least M^-1 norm of the rest,
///
/// which is Gauss's principle of least constraint: a law that is a set at z_0 (a body that touches
/// an obstacle, or sticks) gives what keeps it from moving on. Where the argument of a law on u
/// leaves z_0 with a velocity, the law is the one on that side. Imposed values have the rate that
/// their functions of t have at t_0. Several unknowns start from what leading_forms.hpp says of
/// them; those without a rate, whose equation holds by itself, take their value from it where the
/// scheme weighs it with that of the step before (hht, midpoint). Throws Failure(not_coercive)
/// where an unknown has no mass, Failure(not_certified) where no a is found, and Failure(bad_value)
/// where a law acts on what is sought.
void start_motion(const Plan& plan, const Discretisation& discretisation, RunState& run);

/// u'(t_0) on all dofs: the given velocity or 0, and on imposed dofs the rate of their values.
Vector starting_velocity(const Problem& problem, const Discretisation& discretisation);

} // namespace hvi::solver
