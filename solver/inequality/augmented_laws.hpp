// The laws of the globally convergent method (fallback.cpp): convex, with multipliers.
//
// With the shift m of each component, jhat = j + m |.|^2 / 2 is convex, and the problem reads
//     S c - theta G^T W M z - (1 - theta) G^T W M z_ref + sum w G^T lambda = r,
//     lambda in d jhat(z),
// theta = 1 where S - G^T W M G is positive definite: then this is one convex problem. Otherwise
// the concave part is linearised at z_ref in part. For a fixed multiplier lambda the Moreau
// envelope of jhat makes a convex C^1 function of c, whose derivative by z is `evaluate`.
//
// Given `parts`, jhat' is the rising part of each law on all of its pieces, and what is taken at
// z_ref is its fall (rise_and_fall.hpp); m and theta are 0 then.
#pragma once

#include "solver/inequality/position.hpp"
#include "solver/inequality/rise_and_fall.hpp"

namespace hvi::solver {

class AugmentedLaws {
public:
  /// Multipliers, states and z_ref from there. `parts`: of each prepared law; null for shifts.
  AugmentedLaws(const Position& at, const std::vector<RiseAndFall>* parts);
  /// New multiplier of jhat for point p at z; with `stiffness`, its D in `d`.
  Small evaluate(int p, const Small& z, bool stiffness);
  /// xi that stands in the equation: lambda - theta m z - (1 - theta) m z_ref.
  Small in_equation(int p, const Small& lambda, const Small& z) const;
  /// D of the concave part alone.
  void take_concave_part(double theta);
  /// Multipliers and states of the arguments there and lambda.
  void hand_over(Position& to) const;

  double shrink = 1.0;  ///< factor of gamma
  Vector lambda, z_ref; ///< per row: multiplier of jhat, point of linearisation
  PointMatrices d;      ///< second derivatives

private:
  double shift(int p) const { return parts_ ? 0.0 : points_.law(p).component(component_[p]).m; }
  Small fall(int p, const Small& otherwise) const; ///< at z_ref; 0 without parts
  void set_stiffness(int p, const Small& y, double size, double gamma);

  const ContactPoints& points_;
  const std::vector<int>& component_;
  const std::vector<RiseAndFall>* parts_;
  double theta_ = 1.0;
  std::vector<GraphPoint> hits_;
};

} // namespace hvi::solver
