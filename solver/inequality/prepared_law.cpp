// Components of a law's graph and their resolvents (prepared_law.hpp).
#include "solver/inequality/prepared_law.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {
double finite_or(double v, double otherwise) { return std::isfinite(v) ? v : otherwise; }
} // namespace

PreparedLaw::PreparedLaw(const Law& law, const LawGraph& graph)
    : law_(&law), graph_(&graph), radial_(law.spec().radial) {
  component_of_.resize(graph.pieces());
  const auto scale_by = [&](double s) { // what stands for infinity is no size of a multiplier
    if (std::abs(s) < unbounded_slope) slope_scale_ = std::max(slope_scale_, std::abs(s));
  };
  scale_by(law.slope(graph, piece_of(graph, 0.0), 0.0));
  for (std::size_t i = 0; i < graph.breaks.size(); ++i)
    scale_by(graph.left[i]), scale_by(graph.right[i]);
  int first = 0;
  for (int i = 0; i < graph.pieces(); ++i) {
    component_of_[i] = components();
    if (i + 1 < graph.pieces() && !(graph.left[i] > graph.right[i])) continue;
    add_component(first, i);
    first = i + 1;
  }
}

/// The steepest descent of the slope on a piece, taken into that of its component; radial: across
/// the direction of slip, too, which matters beyond a jump down only (else mu(r) >= mu(0) - m r).
double PreparedLaw::descend(int piece, LawComponent& c) const {
  const double low = piece_low(*graph_, piece, radial_), high = piece_high(*graph_, piece);
  const auto range = law_->curvature_range(*graph_, piece, low, high);
  // What was only seen may be a little short, and rounding must not undo monotonicity.
  double m = std::max(0.0, -range.low) * (range.exact ? 1.0 + 1e-12 : 1.01);
  c.proved = c.proved && range.exact && std::isfinite(m);
  if (!std::isfinite(m))
    m = std::max(0.0, finite_or(-law_->curvature(*graph_, piece, (low + high) / 2), 0.0)) * 1e3;
  if (radial_) m = std::max(m, descent_across(piece, low, high));
  c.m = std::max(c.m, m);
  return m;
}

double PreparedLaw::descent_across(int piece, double low, double high) const {
  double m = 0.0;
  const double start = std::max(low, 0.0), end = std::isfinite(high) ? high : 2.0 * start + 1.0;
  for (int k = 1; k <= 32; ++k) {
    const double r = start + (end - start) * (k / 32.0);
    m = std::max(m, -law_->slope(*graph_, piece, r) / r);
  }
  return m;
}

void PreparedLaw::add_component(int first, int last) {
  LawComponent c;
  c.first = first, c.last = last;
  c.low = piece_low(*graph_, first, false);
  c.high = piece_high(*graph_, last);
  for (int i = first; i <= last; ++i) softens_.push_back(descend(i, c) > 0.0);
  if (std::isfinite(c.low)) {
    c.low_s = graph_->right[first - 1];
    c.low_d = finite_or(law_->curvature(*graph_, first, c.low), 0.0);
    // Towards the origin a radial slope must not change sign.
    if (radial_ && c.low_s >= 0.0) c.low_d = std::min(c.low_d, c.low_s / c.low);
  }
  if (std::isfinite(c.high)) {
    c.high_s = graph_->left[last];
    c.high_d = finite_or(law_->curvature(*graph_, last, c.high), 0.0);
  }
  components_.push_back(c);
}

bool PreparedLaw::valid_state(int state) const {
  if (state == -1) return radial_;
  if (state < 0 || state / 2 >= graph_->pieces()) return false;
  if (state % 2 == 0) return true;
  const int b = state / 2;
  return b + 1 < graph_->pieces() && graph_->left[b] <= graph_->right[b];
}

GraphPoint PreparedLaw::on_component(int k, double z) const {
  const LawComponent& c = components_[k];
  if (z < c.low) return {2 * c.first, z, c.low_s + c.low_d * (z - c.low), c.low_d};
  if (z > c.high) return {2 * c.last, z, c.high_s + c.high_d * (z - c.high), c.high_d};
  GraphPoint p{0, z, 0.0, 0.0};
  const int piece = std::clamp(piece_of(*graph_, z), c.first, c.last);
  p.state = 2 * piece;
  law_->slope_and_curvature(*graph_, piece, z, p.s, p.d);
  return p;
}

GraphPoint PreparedLaw::resolvent(int k, double y, double gamma, const GraphPoint& hint) const {
  const LawComponent& c = components_[k];
  const LawGraph& g = *graph_;
  const double a = 1.0 + gamma * c.m;
  if (radial_) { // the ball at the origin
    const double s0 =
        std::isfinite(c.low) ? c.low_s - c.low_d * c.low : law_->slope(g, c.first, 0.0);
    if (y <= gamma * s0 || y <= 0.0) return {-1, 0.0, y / gamma, 0.0};
  }
  int i = std::clamp(hint.state < 0 ? c.first : hint.state / 2, c.first, c.last);
  for (int guard = 0; guard <= 2 * g.pieces(); ++guard) {
    if (i > c.first) {
      const double b = g.breaks[i - 1];
      if (y < a * b + gamma * g.right[i - 1]) {
        if (y >= a * b + gamma * g.left[i - 1]) return {2 * i - 1, b, (y - a * b) / gamma, 0.0};
        --i;
        continue;
      }
    }
    if (i < c.last) {
      const double b = g.breaks[i];
      if (y > a * b + gamma * g.left[i]) {
        if (y <= a * b + gamma * g.right[i]) return {2 * i + 1, b, (y - a * b) / gamma, 0.0};
        ++i;
        continue;
      }
    }
    break;
  }
  return solve_inside(c, i, y, a, gamma, hint.z);
}

/// Solves a z + gamma s(z) = y on one piece or on the extension beyond it.
GraphPoint PreparedLaw::solve_inside(const LawComponent& c, int piece, double y, double a,
                                     double gamma, double guess) const {
  const auto line = [&](double at, double s, double d) {
    const double step = (y - a * at - gamma * s) / (a + gamma * d);
    return GraphPoint{2 * piece, at + step, s + d * step, d};
  };
  if (piece == c.first && std::isfinite(c.low) && y < a * c.low + gamma * c.low_s)
    return line(c.low, c.low_s, c.low_d);
  if (piece == c.last && std::isfinite(c.high) && y > a * c.high + gamma * c.high_s)
    return line(c.high, c.high_s, c.high_d);
  const auto& p = graph_->smooth[piece];
  if (p.degree == 0 || p.degree == 1) return line(p.centre, p.a[0], p.degree == 1 ? p.a[1] : 0.0);
  return iterate(piece, y, a, gamma, guess);
}

/// Newton kept inside a shrinking bracket; bisection where it leaves it.
GraphPoint PreparedLaw::iterate(int piece, double y, double a, double gamma, double guess) const {
  double low = piece_low(*graph_, piece, radial_), high = piece_high(*graph_, piece);
  double z = std::clamp(std::isfinite(guess) ? guess : 0.0, low, high);
  GraphPoint p{2 * piece, z, 0.0, 0.0};
  for (int k = 0; k < 200; ++k) {
    law_->slope_and_curvature(*graph_, piece, z, p.s, p.d);
    p.z = z;
    const double f = a * z + gamma * p.s - y;
    if (f == 0.0 || !std::isfinite(f)) break;
    (f > 0.0 ? high : low) = z;
    const double df = a + gamma * p.d;
    double next = z - f / df;
    if (!(next > low && next < high) || !(df > 0.0)) {
      if (std::isfinite(low) && std::isfinite(high))
        next = low + (high - low) / 2.0;
      else
        next = std::isfinite(next) && df > 0.0 ? std::clamp(next, low, high) : z - f / a;
    }
    if (std::abs(next - z) <= 0x1p-52 * std::abs(z)) break;
    z = next;
  }
  if (!std::isfinite(p.d)) p.d = 0.0;
  return p;
}

} // namespace hvi::solver
