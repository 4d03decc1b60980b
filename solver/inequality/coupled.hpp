// Laws whose bounds are other laws' multipliers (Coulomb's friction), all at once.
//
// Semismooth Newton on the natural map of the coupled laws (P. Alart, A. Curnier, A mixed
// formulation for frictional contact problems prone to Newton like solution methods, Computer
// Methods in Applied Mechanics and Engineering 92, 1991): with y_p = z_p + gamma_p xi_p
//
//     F1 = r - S c - G^T W xi,        F2_p = z_p - J_p(y_p; b_p),
//
// J_p the resolvent of p's law, b_p = share times the multiplier that its normal law's resolvent
// gives. Steps are shortened until the merit function |F1|^2 / S_ii + |F2|^2 w / gamma falls.
// `share` < 1 makes the bounds smaller: at 0 the laws are plain ones, from there solutions are
// followed, and where they turn back the way goes on by arc length (coupled_path.hpp).
#pragma once

#include "solver/inequality/coupled_tangent.hpp"

namespace hvi::solver {

/// Where a search stands.
struct CoupledPlace {
  Vector c, xi;
  std::vector<int> state, component;
};

class CoupledNewton {
public:
  CoupledNewton(Position& at, CoupledBounds& bounds, CoupledTangent& tangent, double tolerance,
                InequalityReport& report);

  CoupledPlace here() const;
  void go(const CoupledPlace& place);

  // Methods from the present place; false: they do not get there.
  bool newton(int limit);
  bool solve(int limit); ///< Newton, with points that leave a component of their law moved on
  bool raise_share();    ///< to 1, by Newton's method at ever larger shares

  /// |F1|^2 / S_ii + |F2|^2 w / gamma at (c, xi), an energy; places the points.
  double merit();
  /// Puts resting points exactly where they rest; true when the multipliers then solve the problem.
  bool finish(double snap_factor, double& ratio);
  void weigh_evenly() { scale_ = 1.0; } ///< z and xi in the natural map, as gamma says

private:
  bool newton_with_scales(int limit);
  void classify();
  double projected(int p) const;
  double line_search(const CoupledStep& step, double limit, double& after);
  double multipliers(double snap_factor);

  Position& at_;
  CoupledBounds& bounds_;
  CoupledTangent& tangent_;
  double tolerance_;
  InequalityReport& report_;
  double scale_ = 1.0; ///< factor of gamma in the natural map
  Vector trial_;
};

} // namespace hvi::solver
