// Energies of single points and their bounds (point_energy.hpp).
#include "solver/inequality/point_energy.hpp"

#include "solver/common/numbers.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr int cells_of_curved_piece = 8;

int lowest_piece_of(const CurveGraph& g, double z) {
  int piece = 0;
  while (piece + 1 < g.pieces() && z > g.high(piece)) ++piece;
  return piece;
}

double conjugate_of_line(const EnergySegment& s, double slope, double& at) {
  if (s.curvature <= 0.0) {
    const double low = slope * s.a - s.fa, high = slope * s.b - s.fb;
    at = low > high ? s.a : s.b;
    return std::max(low, high);
  }
  at = std::clamp(s.a + (slope - s.slope) / s.curvature, s.a, s.b);
  const double by = at - s.a;
  return slope * at - (s.fa + by * (s.slope + 0.5 * s.curvature * by));
}

double conjugate_of_curve(const PointEnergy& law, const EnergySegment& s, double slope,
                          double& at) {
  const double excess = std::max(0.0, -s.curvature), middle = 0.5 * (s.a + s.b);
  double low = s.a, high = s.b, best = infinity;
  for (int k = 0; k < 60; ++k) { // the slope of what is maximised falls: bisection
    at = k == 0 ? low : (k == 1 ? high : 0.5 * (low + high));
    const double r = slope - law.slope(s.piece, at) - excess * (at - middle);
    // concave: below its tangent at `at` on all of what is left
    const double value =
        slope * at - law.on_piece(s.piece, at) - 0.5 * excess * (at - s.a) * (at - s.b);
    best = std::min(best, value + std::max(0.0, r > 0.0 ? r * (high - at) : r * (low - at)));
    if (k == 0 && r <= 0.0) return best;
    if (k == 1 && r >= 0.0) return best;
    if (k > 1) (r > 0.0 ? low : high) = at;
    if (high - low <= 1e-12 * std::max(std::abs(low), std::abs(high))) break;
  }
  return best;
}

} // namespace

PointEnergy::PointEnergy(const CurvePoint& point)
    : graph(point.graph), weight(point.weight), low(-infinity), high(infinity) {
  for (int b = 0; b + 1 < graph->pieces(); ++b) {
    if (graph->below(b) <= -unbounded_slope) low = graph->at(b);
    if (graph->above(b) >= unbounded_slope) high = std::min(high, graph->at(b));
  }
}

double PointEnergy::law(double z) const {
  return weight * graph->potential(lowest_piece_of(*graph, z), z);
}

double PointEnergy::on_piece(int piece, double z) const {
  return weight * graph->potential(piece, z) + 0.5 * d * z * z;
}

double PointEnergy::slope(int piece, double z) const {
  double s = 0.0, curvature = 0.0;
  graph->slope(piece, z, s, curvature);
  return weight * s + d * z;
}

double PointEnergy::at(double z) const {
  return holds(z) ? on_piece(lowest_piece_of(*graph, z), z) : infinity;
}

/// By its tangent, or a parabola.
double PointEnergy::least_on(int piece) const {
  const double from = std::max(graph->low(piece), low), to = std::min(graph->high(piece), high);
  if (!(from < to)) return infinity;
  const double k = weight * graph->least_curvature(piece, from, to) + d;
  const bool bounded = std::isfinite(from) && std::isfinite(to);
  const double start = std::isfinite(from) ? from : (std::isfinite(to) ? to : 0.0);
  const double rise = slope(piece, start), value = on_piece(piece, start);
  if (k > 0.0) return value - 0.5 * rise * rise / k;
  if (!bounded || !std::isfinite(k)) return -infinity;
  const double length = to - from; // the tangent of phi - k (z - from) (z - to) / 2
  return value + std::min(0.0, (rise + 0.5 * k * length) * length);
}

bool PointEnergy::convex() const {
  for (int b = 0; b + 1 < graph->pieces(); ++b)
    if (graph->below(b) > graph->above(b)) return false;
  for (int i = 0; i < graph->pieces(); ++i)
    if (!(graph->least_curvature(i, graph->low(i), graph->high(i)) >= 0.0)) return false;
  return true;
}

double PointEnergy::inside(double z) const { return std::clamp(z, low, high); }

bool PointEnergy::reaches(double z) const {
  return z >= low - 1e-9 * std::abs(z) && z <= high + 1e-9 * std::abs(z);
}

bool make_cells(const PointEnergy& law, double low, double high, std::vector<EnergyCell>& out) {
  const CurveGraph& g = *law.graph;
  for (int i = 0; i < g.pieces(); ++i) {
    const double from = std::max(g.low(i), low), to = std::min(g.high(i), high);
    if (!(from < to)) continue;
    const int count = g.straight(i) ? 1 : cells_of_curved_piece;
    for (int k = 0; k < count; ++k) {
      const double a = from + (to - from) * k / count,
                   b = k + 1 == count ? to : from + (to - from) * (k + 1) / count;
      const double curvature = g.least_curvature(i, a, b);
      if (!std::isfinite(curvature)) return false;
      out.push_back({a, b, curvature, i, g.straight(i)});
    }
  }
  return true;
}

std::vector<EnergySegment> make_segments(const PointEnergy& law,
                                         const std::vector<EnergyCell>& cells, double low,
                                         double high) {
  std::vector<EnergySegment> out;
  for (const EnergyCell& cell : cells) {
    const double a = std::max(cell.low, low), b = std::min(cell.high, high);
    if (!(a <= b)) continue;
    out.push_back({a, b, law.on_piece(cell.piece, a), law.on_piece(cell.piece, b),
                   law.slope(cell.piece, a), law.weight * cell.curvature + law.d, cell.piece,
                   cell.straight});
  }
  return out;
}

double conjugate(const PointEnergy& law, const std::vector<EnergySegment>& segments, double slope,
                 double& at) {
  double best = -infinity, where = 0.0;
  for (const EnergySegment& s : segments) {
    const double value =
        s.straight ? conjugate_of_line(s, slope, where) : conjugate_of_curve(law, s, slope, where);
    if (value > best) best = value, at = where;
  }
  return best;
}

} // namespace hvi::solver
