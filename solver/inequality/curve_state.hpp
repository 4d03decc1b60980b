// States on the equilibrium curve (equilibrium_curve.hpp), and what is fixed along it.
#pragma once

#include "solver/inequality/curve_graph.hpp"
#include "solver/linear/sparse.hpp"

namespace hvi::solver {

struct CurvePoint {
  const CurveGraph* graph;
  double weight;
};

/// A point of the curve. Each contact point stands inside a piece of its law's graph, where its
/// argument moves, or upright: on the vertical line at a jump of the slope, where its multiplier
/// moves.
struct CurveState {
  Vector z, xi;
  Vector curvature;       ///< of the laws at z; of upright points it says nothing
  std::vector<int> place; ///< of each point: 2 i inside piece i, 2 i + 1 upright at break i
  double load = 0.0;      ///< l

  bool upright(int p) const { return place[p] % 2 == 1; }
};

/// The body and the laws of its points. The unknown of a point that is upright is the part a_pp xi
/// of its argument that its own multiplier makes, else z: all unknowns have the unit of z.
struct CurveProblem {
  /// C dense, symmetric and positive definite, one point a row.
  CurveProblem(DenseMatrix compliance, std::vector<CurvePoint> points);

  int size() const { return static_cast<int>(points.size()); }
  bool falls(const CurveState& at, int p) const; ///< is it upright at a downward jump?
  bool curved(const CurveState& at, int p) const {
    return !at.upright(p) && !points[p].graph->straight(at.place[p] / 2);
  }
  double unknown(const CurveState& at, int p) const {
    return at.upright(p) ? at.xi[p] * a(p, p) : at.z[p];
  }
  void move(CurveState& at, int p, double by) const; ///< the unknown, by this much
  /// The unknown at an end of the point's place; `side`: 1 the upper end, -1 the lower.
  double end(const CurveState& at, int p, int side) const;
  /// Gives the points inside pieces the slopes and curvatures of their laws at z.
  void take_slopes(CurveState& at) const;

  DenseMatrix compliance, a; ///< C, C W
  std::vector<CurvePoint> points;
};

} // namespace hvi::solver
