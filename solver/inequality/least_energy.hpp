// The least energy of a reduced problem that is not convex, with a proof: branch and bound.
//
// On the laws' arguments, C = G S^-1 G^T, b the arguments of the free body, the energy over that of
// the free body is
//
//     E(z) = (z - b)^T C^-1 (z - b) / 2 + sum_p w_p j_p(z_p).
//
// A diagonal D with C^-1 - D positive definite is taken from the body and given to the laws:
// phi_p(z) = w_p j_p(z) + d_p z^2 / 2. On a box of arguments each phi_p is bounded from below by a
// convex function (cells of the law with curvature >= k: + max(0, -k) (z - a)(z - b) / 2, then the
// convex hull). The minimum of that convex problem, bounded by Lagrangian duality, is a lower bound
// of E on the box. Boxes are halved where the bound is worst, the lowest bound first, until it
// meets the lowest energy found (J. E. Falk and R. M. Soland, An algorithm for separable nonconvex
// programming problems, 1969; I. P. Androulakis, C. D. Maranas and C. A. Floudas, alphaBB: a global
// optimization method for general constrained nonconvex problems, 1995).
#pragma once

#include "solver/common/numbers.hpp"
#include "solver/inequality/box_bound.hpp"

#include <functional>

namespace hvi::solver {

struct LeastEnergyResult {
  LowestEnergy lowest;      ///< of the best state found, over the energy of the free body; its
                            ///< scale at least b^T D b / 2
  double bound = -infinity; ///< no state has less; -infinity where nothing is known
  int boxes = 0;
  /// (lowest - bound) / scale: by how much less another state may have.
  double gap() const;
};

class LeastEnergy {
public:
  /// From the forces of a candidate to a solution nearby: its forces, or an empty vector.
  using Descend = std::function<Vector(const Vector&)>;

  /// C dense and square, one point a row; scalar laws only. Keeps a reference to C.
  LeastEnergy(const DenseMatrix& compliance, const std::vector<CurvePoint>& points);

  /// Over that of the free body, of the body under the points' forces (w_p xi_p).
  LowestEnergy energy(const Vector& b, const Vector& force) const;
  /// `force` is that of the best state known.
  LeastEnergyResult search(const Vector& b, const Vector& force, const Descend& descend) const;

private:
  const DenseMatrix& c_;
  std::vector<PointEnergy> points_;
};

} // namespace hvi::solver
