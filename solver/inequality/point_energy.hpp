// The energy of one point's law with a share of the body's, and lower bounds of it
// (least_energy.hpp).
#pragma once

#include "solver/inequality/curve_state.hpp"

#include <vector>

namespace hvi::solver {

/// phi(z) = w j(z) + d z^2 / 2 of one point.
struct PointEnergy {
  explicit PointEnergy(const CurvePoint& point);

  double law(double z) const; ///< w j(z)
  double on_piece(int piece, double z) const;
  double slope(int piece, double z) const;
  double at(double z) const;        ///< on the lowest piece that holds z; infinite outside
  double least_on(int piece) const; ///< it is nowhere less on the piece
  bool convex() const;              ///< j: no slope falls, no jump goes down
  double inside(double z) const;    ///< the argument of finite energy that is closest
  bool reaches(double z) const;     ///< is the energy finite there, but for rounding of z?
  bool holds(double z) const { return z >= low && z <= high; }

  const CurveGraph* graph;
  double weight;
  double low, high; ///< arguments between them have finite energy
  double d = 0.0;
};

/// A part of a law's graph inside one piece, with a lower bound of the slope's derivative.
struct EnergyCell {
  double low, high, curvature;
  int piece;
  bool straight;
};

/// What of a cell lies within a box: phi there, made convex.
struct EnergySegment {
  double a, b, fa, fb, slope, curvature; ///< slope of phi at a, least curvature of phi
  int piece;
  bool straight;
};

/// The cells between two arguments; false where a curvature has no bound.
bool make_cells(const PointEnergy& law, double low, double high, std::vector<EnergyCell>& out);
/// The cells within a box. A box of one argument has one segment without length.
std::vector<EnergySegment> make_segments(const PointEnergy& law,
                                         const std::vector<EnergyCell>& cells, double low,
                                         double high);
/// An upper bound of max slope z - phi(z) on the segments: the tight one of phi made convex on
/// each. `at`: where it is attained.
double conjugate(const PointEnergy& law, const std::vector<EnergySegment>& segments, double slope,
                 double& at);

} // namespace hvi::solver
