// The path of solutions of coupled laws as their bounds grow from 0 to what they are (coupled.hpp).
//
// A solution exists at every share, but those at growing shares need not hang together: the path
// may turn back, at a limit point or at a kink where a point changes its state, and reach share 1
// by a detour. So it is followed by its arc length (H. B. Keller, Numerical solution of bifurcation
// and nonlinear eigenvalue problems, in: Applications of Bifurcation Theory, 1977): with its
// direction (a, b) at the last solution each is sought in the plane
//
//     <a, c - c_last> + b (share - share_last) = length.
//
// Where that plane holds none at any length there is a kink: the path goes on along other pieces.
#pragma once

#include "solver/inequality/coupled.hpp"

namespace hvi::solver {

class SharePath {
public:
  SharePath(Position& at, CoupledBounds& bounds, CoupledTangent& tangent, CoupledNewton& newton,
            InequalityReport& report);
  /// From a solution on by arc length, wherever the share goes; true when it is 1.
  bool follow();

private:
  /// A solution on the path.
  struct Waypoint {
    CoupledPlace place;
    double share = 0.0;
  };
  /// A direction of the path, with unit length in (c, share); xi belongs to c.
  struct Heading {
    Vector c, xi;
    double share = 0.0;
  };
  Waypoint here() const { return {newton_.here(), bounds_.share()}; }
  void go(const Waypoint& to);
  double product(const Vector& a, const Vector& b) const; ///< of displacements, without a unit
  double product(const Heading& a, const Heading& b) const;
  bool step(const Waypoint& last, const Heading& along, double length);
  bool look_ahead(Heading& out);
  bool keeps_to_path(const Waypoint& last, const Heading& along, double length, Heading& next);
  bool turn(const Waypoint& last, const Heading& along);

  Position& at_;
  CoupledBounds& bounds_;
  CoupledTangent& tangent_;
  CoupledNewton& newton_;
  InequalityReport& report_;
  double energy_ = 1.0; ///< of displacements: their unit
};

} // namespace hvi::solver
