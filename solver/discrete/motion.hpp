// The schemes of problems with u''.
#pragma once

#include "solver/discrete/time_scheme.hpp"

namespace hvi::solver {

/// u'(t_n) = factor d_n - carry d_{n-1} by BDF2, or by backward Euler, where carry is 0.
struct Bdf2Weights {
  double factor, carry;
};
Bdf2Weights bdf2_at(const TimeGrid& grid, int n);

/// With v = u', a = u'', d_n = u_n - u_{n-1}, k the length of step n:
///
/// Backward Euler, BDF2: a from v as v from u.
///
/// newmark, beta = 1/4, gamma = 1/2 (the trapezoidal rule; N. M. Newmark, A method of computation
/// for structural dynamics, J. Eng. Mech. Div. ASCE 85 (1959) 67-94):
///   d_n = k v_{n-1} + k^2 ((1/2 - beta) a_{n-1} + beta a_n),
///   v_n = v_{n-1} + k ((1 - gamma) a_{n-1} + gamma a_n).
///
/// hht, alpha in [-1/3, 0], beta = (1 - alpha)^2 / 4, gamma = 1/2 - alpha: the same formulas, and
///   M a_n + (1 + alpha) F_n - alpha F_{n-1} = 0,    F_n all other forces at t_n,
/// which is divided by 1 + alpha here (H. M. Hilber, T. J. R. Hughes, R. L. Taylor, Improved
/// numerical dissipation for time integration algorithms in structural dynamics, Earthquake Eng.
/// Struct. Dyn. 5 (1977) 283-292).
///
/// Of imposed values no equation damps what these formulas carry from step to step: with d_n given,
/// a_n = ... - a_{n-1} answers each kink, and each rounding, for ever. Their v_n are the BDF2
/// differences of the values and their a_n those of the v_n (in the first step 2 d_1 / k - v_0, and
/// so on): as accurate, and a kink is forgotten after two steps.
///
/// midpoint: M (v_n - v_{n-1}) / k + A d_n / k + (F_n + F_{n-1}) / 2 + G^T W xi_n = 0,
///   (v_n + v_{n-1}) / 2 = d_n / k, which is u'(t_n) to forms, laws and reports; F: forms in u and
///   in memories, loads. Laws on u are taken at t_n and laws on u' at d_n / k, so that a convex
///   potential of u, and friction, give the body no energy (theory.md).
std::unique_ptr<TimeScheme> scheme_of_motion(const TimeSpec& spec);

} // namespace hvi::solver
