// See slope_bounds.hpp.
#include "solver/law/slope_bounds.hpp"

#include "solver/common/numbers.hpp"
#include "solver/law/descent.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

constexpr int samples = 64;
constexpr double widened = 0.1;

double with_infinity(double s) {
  return std::abs(s) >= unbounded_slope ? std::copysign(infinity, s) : s;
}

/// What the slope of the outermost piece tends to on the side of `sign`.
double limit(const Law& law, const LawGraph& graph, double sign) {
  const int piece = sign < 0.0 ? 0 : graph.pieces() - 1;
  const auto& smooth = graph.smooth[static_cast<std::size_t>(piece)];
  if (smooth.degree >= 0) {
    int degree = smooth.degree;
    while (degree > 0 && smooth.a[static_cast<std::size_t>(degree)] == 0.0) --degree;
    const double leading = smooth.a[static_cast<std::size_t>(degree)];
    return degree == 0 ? with_infinity(leading)
                       : std::copysign(infinity, degree % 2 == 0 ? leading : sign * leading);
  }
  const double scale = argument_scale(graph);
  const double near = law.slope(graph, piece, sign * 1e6 * scale),
               far = law.slope(graph, piece, sign * 1e12 * scale);
  const bool grows = !(std::abs(far) <= 1.5 * std::abs(near) || std::abs(far) <= 1e-6);
  return grows ? std::copysign(infinity, std::isnan(far) ? near : far) : with_infinity(far);
}

/// Takes the extremes inside a piece that neither rises nor falls all along into `out`.
void add_inside(const Law& law, const LawGraph& graph, int piece, SlopeBounds& out) {
  const bool radial = law.spec().radial;
  const double low = piece_low(graph, piece, radial), high = piece_high(graph, piece);
  const auto curvature = law.curvature_range(graph, piece, low, high);
  if (curvature.low >= 0.0 || curvature.high <= 0.0) return;
  const double scale = argument_scale(graph);
  double least = infinity, most = -infinity;
  for (int i = 1; i < samples; ++i) {
    const double share = static_cast<double>(i) / samples, far = share / (1.0 - share) * scale;
    const double r = std::isfinite(low) && std::isfinite(high) ? low + share * (high - low)
                     : std::isfinite(low)                      ? low + far
                     : std::isfinite(high)                     ? high - far
                                           : scale * (2.0 * share - 1.0) / (share * (1.0 - share));
    const double s = law.slope(graph, piece, r);
    least = std::min(least, s), most = std::max(most, s);
  }
  const double more = widened * std::max(std::abs(least), std::abs(most));
  out.low = std::min(out.low, least - more), out.high = std::max(out.high, most + more);
}

} // namespace

SlopeBounds slope_bounds(const Law& law, const LawGraph& graph) {
  SlopeBounds out{infinity, -infinity, 0.0, 0.0};
  const auto add = [&](double s) {
    out.low = std::min(out.low, s), out.high = std::max(out.high, s);
  };
  out.at_plus = limit(law, graph, 1.0);
  add(out.at_plus);
  if (law.spec().radial)
    add(with_infinity(law.slope(graph, 0, 0.0)));
  else
    add(out.at_minus = limit(law, graph, -1.0));
  for (std::size_t i = 0; i < graph.breaks.size(); ++i)
    add(with_infinity(graph.left[i])), add(with_infinity(graph.right[i]));
  for (int piece = 0; piece < graph.pieces(); ++piece) add_inside(law, graph, piece, out);
  return out;
}

} // namespace hvi::solver
