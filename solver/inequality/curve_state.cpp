// States on the equilibrium curve (curve_state.hpp).
#include "solver/inequality/curve_state.hpp"

#include <algorithm>

namespace hvi::solver {

CurveProblem::CurveProblem(DenseMatrix compliance_, std::vector<CurvePoint> points_)
    : compliance(std::move(compliance_)), a(compliance), points(std::move(points_)) {
  for (int p = 0; p < size(); ++p) a.col(p) *= points[p].weight;
}

bool CurveProblem::falls(const CurveState& at, int p) const {
  const int b = at.place[p] / 2;
  return at.upright(p) && points[p].graph->below(b) > points[p].graph->above(b);
}

void CurveProblem::move(CurveState& at, int p, double by) const {
  if (at.upright(p))
    at.xi[p] += by / a(p, p);
  else
    at.z[p] += by;
}

double CurveProblem::end(const CurveState& at, int p, int side) const {
  const CurveGraph& g = *points[p].graph;
  const int i = at.place[p] / 2;
  if (!at.upright(p)) return side > 0 ? g.high(i) : g.low(i);
  const double s = side > 0 ? std::max(g.below(i), g.above(i)) : std::min(g.below(i), g.above(i));
  return s * a(p, p);
}

void CurveProblem::take_slopes(CurveState& at) const {
  for (int p = 0; p < size(); ++p)
    if (!at.upright(p)) points[p].graph->slope(at.place[p] / 2, at.z[p], at.xi[p], at.curvature[p]);
}

} // namespace hvi::solver
