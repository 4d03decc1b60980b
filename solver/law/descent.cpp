// The steepest descent of one piece of a law (descent.hpp).
#include "solver/law/descent.hpp"

#include "solver/common/numbers.hpp"
#include "solver/law/towards.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::solver {

namespace {
/// A few operations' rounding.
constexpr double rounding = 64.0 * 0x1p-52;

/// The largest |curvature| at a few points of a piece.
double curvature_size(const SmoothFunction& f, const LawGraph& graph, double low, double high) {
  const double scale = argument_scale(graph);
  const double a = std::max(low, -scale), b = std::min(high, scale);
  double size = 0.0;
  for (const double r : {a, a + (b - a) / 4.0, a + (b - a) / 2.0, a + 3.0 * (b - a) / 4.0, b}) {
    double s = 0.0, c = 0.0;
    f.slope_and_curvature(r, graph.x, graph.t, s, c);
    if (std::isfinite(c)) size = std::max(size, std::abs(c));
  }
  return size;
}
} // namespace

double argument_scale(const LawGraph& graph) {
  double scale = 1.0;
  for (const double b : graph.breaks) scale = std::max(scale, std::abs(b));
  return scale;
}

Bracket without_rounding(const Bracket& b, double size) {
  return b.low <= rounding * size && b.high <= rounding * size ? Bracket{} : b;
}

SlopeRange polynomial_range(const LawGraph::Smooth& p, double low, double high) {
  SlopeRange range{infinity, -infinity, low};
  const auto take = [&](double v, double at) {
    if (v < range.low) range.low = v, range.low_at = at;
    range.high = std::max(range.high, v);
  };
  if (p.degree <= 1) {
    take(p.a[1] * (p.degree == 1), std::isfinite(low) ? low : (std::isfinite(high) ? high : 0.0));
    return range;
  }
  const auto end = [&](double r) {
    if (std::isfinite(r)) return take(polynomial_slope(p, r), r);
    const bool up =
        p.a[p.degree] > 0.0 ? (r > 0.0 || p.degree % 2 == 1) : (r < 0.0 && p.degree % 2 == 0);
    take(up ? infinity : -infinity, r);
  };
  end(low), end(high);
  double second[4]{};
  for (int k = 2; k <= p.degree; ++k) second[k - 2] = k * (k - 1) * p.a[k];
  const auto n = static_cast<std::size_t>(p.degree - 1);
  for (const double s : polynomial_roots({second, n}, low - p.centre, high - p.centre))
    take(polynomial_slope(p, p.centre + s), p.centre + s);
  return range;
}

Descent polynomial_descent(const LawGraph::Smooth& p, double low, double high) {
  const SlopeRange range = polynomial_range(p, low, high);
  if (!(range.low < 0.0)) return {};
  return {Bracket::exactly(-range.low), range.low_at};
}

Descent smooth_descent(const SmoothFunction& f, const LawGraph& graph, double low, double high,
                       ProofEffort effort) {
  const double size = curvature_size(f, graph, low, high);
  SupremumRange range{low, high, argument_scale(graph)};
  range.others.fixed = fixed_at(graph.x, graph.t);
  const LargestValue found =
      f.descent(range, graph.x, graph.t, {effort.evaluations, effort.digits, rounding * size, 0.0});
  return {without_rounding(found.value, size), found.at[0]};
}

std::optional<double> steep_end(const SmoothFunction& f, const LawGraph& graph, double low,
                                double high, double sign) {
  for (const auto& [at, side] : {std::pair{low, 1.0}, {high, -1.0}}) {
    if (!std::isfinite(at)) continue;
    double slope = 0.0, there = 0.0;
    f.slope_and_curvature(at, graph.x, graph.t, slope, there);
    if (std::isfinite(there)) continue;
    const Expr rise = derivative(f.slope_expression(), slot::r);
    if (grows_towards(Expr(sign) * rise, {at, side, graph.x, graph.t})) return at;
  }
  return {};
}

GraphJumps jumps_of(const LawGraph& g, bool radial, double origin) {
  GraphJumps out;
  const auto jump = [&](double l, double r, double at) {
    for (const double s : {std::abs(l), std::abs(r)}) {
      if (s >= unbounded_slope)
        out.unbounded = true;
      else
        out.slope_scale = std::max(out.slope_scale, s);
    }
    out.up = out.up || l < r;
    if (l > r && !std::exchange(out.down, true)) out.down_at = at;
  };
  for (std::size_t i = 0; i < g.breaks.size(); ++i) jump(g.left[i], g.right[i], g.breaks[i]);
  if (radial)
    jump(-origin, origin, 0.0);
  else if (std::abs(origin) < unbounded_slope) // a wall may stand at 0
    out.slope_scale = std::max(out.slope_scale, std::abs(origin));
  return out;
}

} // namespace hvi::solver
