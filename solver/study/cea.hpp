// The terms of the paper's Cea type inequality (Theorem "CEA"), beside the error of a run.
//
//   max ||u_n - u_n^hk||^2 <= C [ k sum ( ||delta(u_l - v_l)||^2 + ||M(u_l - v_l)||_X + |S_l(v_l)|
//                                         + ||delta_l||^2 ) + ||e_0||^2 + k^2 + max ||u_n - v_n||^2
//                                         ]
//
// with v_l the Lagrange interpolant of u(t_l), delta_l = (u_l - u_{l-1})/k - u'(t_l) and the
// residual
//
//   S_n(v) = < A u_n' + B u_n + R_n u - f_n, v - u_n > + J^0(M u_n; M v - M u_n).
#pragma once

#include "solver/study/reference.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <span>

namespace hvi::solver {

struct CeaTerms {
  double interpolation = 0.0;      ///< max ||u_n - v_n||^2
  double interpolation_rate = 0.0; ///< k sum ||delta(u_l - v_l)||^2
  double trace = 0.0;              ///< k sum ||M(u_l - v_l)||_X
  double residual = 0.0;           ///< k sum |S_l(v_l)|
  double largest_residual = 0.0;   ///< max |S_l(v_l)|, no term of its own
  double rate = 0.0;               ///< k sum ||delta_l||^2
  double start = 0.0;              ///< ||e_0||^2
  double step = 0.0;               ///< k^2, the longest step
  /// The bracket: the squared error over it is the constant C that this run needs.
  double bound() const {
    return interpolation + interpolation_rate + trace + residual + rate + start + step;
  }
};

/// The solution that stands for u: functions of a space finer than the run's, at any time.
struct FineSolution {
  Problem problem; ///< its mesh and grid are not read
  std::shared_ptr<const Discretisation> discretisation;
  std::function<Vector(double)> u, rate;
};
/// An exact solution, interpolated by P2 on the run's mesh refined once.
FineSolution fine_exact(const Problem& problem, const Mesh& coarse, std::vector<Expr> exact);
/// The steps of a finer run; its rate is the difference quotient.
FineSolution fine_trajectory(const Problem& problem, std::shared_ptr<const Trajectory> trajectory);

/// The terms for a run on that space and the plan's time grid. R_n u is integrated with u affine on
/// a step and exact kernel integrals: an error of order k^2 ||v - u|| in S_n, which is itself of
/// the order of ||M(v - u)||. Nothing for a static plan, for several unknowns, with inertia, where
/// a law acts on u' or reads the solution or another multiplier (the paper's laws act on u alone),
/// where forms, loads or laws change with states or in time, and where a law is unbounded
/// (unilateral contact): J^0 is infinite there, the interpolant need not be admissible, and the
/// inequality says nothing.
std::optional<CeaTerms> cea_terms(const FineSolution& solution, const Problem& problem,
                                  const Discretisation& coarse);

} // namespace hvi::solver
