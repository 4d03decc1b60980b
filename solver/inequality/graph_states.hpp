// Where the points stand on the graphs of their laws, and the graphs linearised there.
//
// Each point has a component of its graph, a state on it (InequalityState) and a point (z_hat,
// xi_hat) of the graph with a stiffness D: xi = xi_hat + D (z - z_hat).
#pragma once

#include "solver/inequality/points.hpp"

namespace hvi::solver {

/// The smallest multiplier that a law allows at z; 0 where it allows none, as the certificate
/// finds.
Small least_multiplier(const PreparedLaw& law, const Small& z);

class GraphStates {
public:
  explicit GraphStates(const ContactPoints& points);

  /// Linearises about the given state near z.
  void enter(int p, const Vector& z, const Vector& xi);
  /// The resolvent of z + gamma xi: new state, new linearisation. `shrink`: a factor of gamma.
  void classify(int p, const Vector& z, const Vector& xi, double shrink);
  /// All rows are held: at a break of a scalar law, at the origin of a radial one.
  bool resting(int p) const;
  Small times_stiffness(int p, const Small& v) const; ///< D v
  Small on_tangent(int p, const Vector& z) const;     ///< xi_hat + D (z - z_hat)
  /// Puts a point that rests at a break exactly there, where its rows touch one unknown each: its
  /// finite stiffness left it there up to 1e-13 of its compliance.
  void settle(int p, Vector& c) const;

  std::vector<int> state, component;
  Vector z_hat, xi_hat;
  PointMatrices d;

private:
  void enter_given(int p, const Small& z);
  void linearise(int p, const GraphPoint& hit, const Small& direction, const Vector& xi);

  const ContactPoints& points_;
};

} // namespace hvi::solver
