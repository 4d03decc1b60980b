// The numbers of hypothesis H(J) for one law: relaxed monotonicity, growth, scales (law.hpp).
#include "solver/law/law.hpp"
#include "solver/law/smooth.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A size for the arguments of a law: that of its breaks, else 1.
double scale_of(const LawGraph& graph) {
  double scale = 0.0;
  for (const double b : graph.breaks) scale = std::max(scale, std::abs(b));
  return scale > 0.0 ? scale : 1.0;
}

/// Sample points of [low, high]: dense towards both ends, out to 1e12 scales where unbounded.
std::vector<double> samples(double low, double high, double scale) {
  std::vector<double> out;
  const double width = std::isfinite(low) && std::isfinite(high) ? high - low : 2e12 * scale;
  const auto from = [&](double end, double sign) {
    for (int k = -12 * 8; k <= 12 * 8; ++k) {
      const double d = scale * std::pow(10.0, k / 8.0);
      if (d < width / 2.0) out.push_back(end + sign * d);
    }
  };
  if (std::isfinite(low)) out.push_back(low), from(low, 1.0);
  if (std::isfinite(high)) out.push_back(high), from(high, -1.0);
  if (!std::isfinite(low) && !std::isfinite(high))
    out.push_back(0.0), from(0.0, 1.0), from(0.0, -1.0);
  if (std::isfinite(width))
    for (int k = 1; k < 64; ++k)
      if (std::isfinite(low) && std::isfinite(high)) out.push_back(low + width * (k / 64.0));
  std::sort(out.begin(), out.end());
  return out;
}

/// Least value of f over sorted points, improved by golden section around the best one.
template <class F>
std::pair<double, double> least(const F& f, const std::vector<double>& points) {
  std::size_t best = 0;
  double value = infinity;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double v = f(points[i]);
    if (v < value) value = v, best = i;
  }
  double a = points[best > 0 ? best - 1 : 0], at = points[best];
  double b = points[std::min(best + 1, points.size() - 1)];
  constexpr double golden = 0.6180339887498949;
  for (int k = 0; k < 80; ++k) {
    const double p = b - golden * (b - a), q = a + golden * (b - a);
    const double fp = f(p), fq = f(q);
    if (fp < value) value = fp, at = p;
    if (fq < value) value = fq, at = q;
    (fp < fq ? b : a) = fp < fq ? q : p;
  }
  return {value, at};
}

Law::CurvatureRange polynomial_range(const LawGraph::Smooth& p, double low, double high) {
  Law::CurvatureRange range{infinity, -infinity, low, true};
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

/// sup |slope| / (1 + |r|) over one piece; infinite when the slope grows faster than r.
double growth(const Law& law, const LawGraph& graph, int piece, double low, double high) {
  const auto& p = graph.smooth[piece];
  const bool unbounded = !std::isfinite(low) || !std::isfinite(high);
  if (p.degree >= 2 && unbounded) return infinity;
  const auto ratio = [&](double r) {
    return std::abs(law.slope(graph, piece, r)) / (1.0 + std::abs(r));
  };
  if (p.degree == 0 || p.degree == 1) { // a quotient of affine functions is monotone: look at ends
    double c = unbounded && p.degree == 1 ? std::abs(p.a[1]) : 0.0;
    for (const double r : {low, high, 0.0})
      if (std::isfinite(r) && r >= low && r <= high) c = std::max(c, ratio(r));
    return c;
  }
  const auto points = samples(low, high, scale_of(graph));
  const auto negative = [&](double r) {
    const double v = ratio(r);
    return std::isnan(v) ? -infinity : -v;
  };
  const double c = -least(negative, points).first;
  // Still rising over the last decades: faster than linear.
  for (const double sign : {-1.0, 1.0}) {
    if (std::isfinite(sign < 0 ? low : high)) continue;
    const double far = ratio(sign * 1e12 * scale_of(graph)),
                 near = ratio(sign * 1e9 * scale_of(graph));
    if (!(far <= 1.5 * near) && !(far <= 1e-3 * c)) return infinity;
  }
  return c;
}

/// sup -mu(r)/r over a piece of a radial law: the descent across the direction of slip.
std::pair<double, double> cross_descent(const Law& law, const LawGraph& graph, int piece,
                                        double low, double high) {
  const auto points = samples(low, high, scale_of(graph));
  const auto f = [&](double r) { return r > 0.0 ? law.slope(graph, piece, r) / r : infinity; };
  const auto [value, at] = least(f, points);
  return {-value, at};
}

} // namespace

Law::CurvatureRange Law::curvature_range(const LawGraph& graph, int piece, double low,
                                         double high) const {
  if (graph.smooth[piece].degree >= 0) return polynomial_range(graph.smooth[piece], low, high);
  const auto points = samples(low, high, scale_of(graph));
  const auto value = [&](double r, double sign) {
    const double v = sign * curvature(graph, piece, r);
    return std::isnan(v) ? infinity : v;
  };
  const auto [down, at] = least([&](double r) { return value(r, 1.0); }, points);
  const auto [up, unused] = least([&](double r) { return value(r, -1.0); }, points);
  return {down, -up, at, false};
}

LawConstants Law::constants(const Point& x, LawTime t) const {
  const LawGraph g = graph(x, t);
  const bool radial = spec().radial;
  LawConstants k;
  k.exact = true;
  const auto descend = [&](double m, double at) {
    if (m > k.m) k.m = m, k.worst_at = at;
  };
  for (int i = 0; i < g.pieces(); ++i) {
    const double low = piece_low(g, i, radial), high = piece_high(g, i);
    const CurvatureRange range = curvature_range(g, i, low, high);
    descend(-range.low, range.low_at);
    k.steepest_ascent = std::max(k.steepest_ascent, range.high);
    k.exact = k.exact && range.exact;
    k.c = std::max(k.c, growth(*this, g, i, low, high));
    if (radial) {
      const auto [m, at] = cross_descent(*this, g, i, low, high);
      descend(m, at);
      k.exact = k.exact && m <= 0.0;
    }
  }
  bool up = false, down = false;
  const auto jump = [&](double l, double r, double at) {
    for (const double s : {std::abs(l), std::abs(r)}) {
      if (s >= unbounded_slope)
        k.c = infinity;
      else
        k.slope_scale = std::max(k.slope_scale, s);
    }
    up = up || l < r;
    down = down || l > r;
    if (l > r) descend(infinity, at);
  };
  for (std::size_t i = 0; i < g.breaks.size(); ++i) jump(g.left[i], g.right[i], g.breaks[i]);
  const double origin = slope(g, piece_of(g, 0.0), 0.0);
  if (radial)
    jump(-origin, origin, 0.0);
  else
    k.slope_scale = std::max(k.slope_scale, std::abs(origin));
  if (up) k.steepest_ascent = infinity;
  k.convex = k.m <= 0.0;
  // j is regular where its slope jumps up, -j where it jumps down; with both kinds neither is.
  k.clarke_regular = !(up && down);
  return k;
}

} // namespace hvi::solver
