// Look-ups in the graph of a law: pieces, Clarke intervals, distances (law.hpp).
#include "solver/common/length.hpp"
#include "solver/law/law.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {

namespace {

/// Distance from xi to the scalar graph over [r - snap, r + snap]: an argument is known up to its
/// rounding only, which a steep slope (contact far stiffer than the body) makes visible in xi. A
/// slope that stands for infinity is no multiplier.
double scalar_distance(const Law& law, const LawGraph& graph, double r, double xi, double snap,
                       double enough) {
  double best = std::numeric_limits<double>::infinity();
  if (!(std::abs(xi) < unbounded_slope)) return best;
  const auto try_interval = [&](double a, double b) {
    if (std::isnan(a) || std::isnan(b)) return;
    best = std::min(best, std::max({0.0, std::min(a, b) - xi, xi - std::max(a, b)}));
  };
  const int piece = piece_of(graph, r);
  const double s = law.slope(graph, piece, r);
  const bool reached = std::abs(s) < unbounded_slope;
  if (reached) try_interval(s, s);
  if (best <= enough) return best;
  auto first = graph.breaks.begin() + piece; // not below r
  while (first != graph.breaks.begin() && first[-1] >= r - snap) --first;
  for (auto b = first; b != graph.breaks.end() && *b <= r + snap; ++b) {
    const auto i = b - graph.breaks.begin();
    try_interval(graph.left[i], graph.right[i]);
  }
  if (best <= enough || !(snap > 0.0)) return best;
  for (const double end : {law.spec().radial ? std::max(r - snap, 0.0) : r - snap, r + snap})
    if (const double there = law.slope(graph, piece_of(graph, end), end);
        reached && std::isfinite(there))
      try_interval(s, there);
  return best;
}

/// The largest slope of a radial law at arguments up to `near`: a law that rises as a root does is
/// far from its value at 0 there.
double largest_near_origin(const Law& law, const LawGraph& graph, double near) {
  double out = std::abs(law.slope(graph, 0, 0.0));
  const auto take = [&](double s) {
    if (std::abs(s) < unbounded_slope) out = std::max(out, std::abs(s));
  };
  if (!(near > 0.0)) return out;
  take(law.slope(graph, piece_of(graph, near), near));
  for (std::size_t i = 0; i < graph.breaks.size() && graph.breaks[i] <= near; ++i)
    take(graph.left[i]), take(graph.right[i]);
  return out;
}

/// How far a number is above 0; what is no number is infinitely far.
double above_zero(double x) {
  if (x <= 0.0) return 0.0;
  return std::isnan(x) ? std::numeric_limits<double>::infinity() : x;
}

} // namespace

double piece_low(const LawGraph& graph, int piece, bool radial) {
  if (piece > 0) return graph.breaks[piece - 1];
  return radial ? 0.0 : -std::numeric_limits<double>::infinity();
}

double piece_high(const LawGraph& graph, int piece) {
  return piece + 1 < graph.pieces() ? graph.breaks[piece] : std::numeric_limits<double>::infinity();
}

int piece_of(const LawGraph& graph, double r) {
  return static_cast<int>(std::lower_bound(graph.breaks.begin(), graph.breaks.end(), r) -
                          graph.breaks.begin());
}

bool has_jumps(const LawGraph& graph, bool radial) {
  constexpr double rounding = 1e-12; // of pieces that meet
  if (radial && graph.origin != 0.0) return true;
  double largest = 0.0, jump = 0.0;
  for (std::size_t i = 0; i < graph.left.size(); ++i) {
    largest = std::max({largest, std::abs(graph.left[i]), std::abs(graph.right[i])});
    jump = std::max(jump, std::abs(graph.right[i] - graph.left[i]));
  }
  return jump > rounding * largest;
}

Interval clarke(const Law& law, const LawGraph& graph, double r, double snap) {
  const double s = law.slope(graph, piece_of(graph, r), r);
  Interval out{s, s};
  const auto first = std::lower_bound(graph.breaks.begin(), graph.breaks.end(), r - snap);
  for (auto b = first; b != graph.breaks.end() && *b <= r + snap; ++b) {
    const auto i = b - graph.breaks.begin();
    out.low = std::min({out.low, graph.left[i], graph.right[i]});
    out.high = std::max({out.high, graph.left[i], graph.right[i]});
  }
  return out;
}

double inclusion_distance(const Law& law, const LawGraph& graph, const double* z, const double* xi,
                          int rows, double snap, double enough) {
  if (!law.spec().radial) return scalar_distance(law, graph, z[0], xi[0], snap, enough);
  const double r = length_of(z, rows);
  double best = std::numeric_limits<double>::infinity();
  // Resting, or slipping the way of xi by less than is known of z.
  if (r <= snap) best = above_zero(length_of(xi, rows) - largest_near_origin(law, graph, snap - r));
  if (r == 0.0) return best;
  // Split xi along and across z: the graph has no part across.
  double along = 0.0;
  for (int k = 0; k < rows; ++k) along += xi[k] * (z[k] / r);
  std::array<double, slot::most_arguments> across; // as many as there are rows
  for (int k = 0; k < rows; ++k) across[k] = xi[k] - along * (z[k] / r);
  const double sideways = length_of(across.data(), rows), size = std::hypot(along, sideways);
  // z is known up to snap, and so up to a turn that moves it as far.
  const double known = 2.0 * std::asin(std::min(1.0, 0.5 * snap / r));
  const double off = above_zero(std::atan2(sideways, std::abs(along)) - known);
  const double turned = std::copysign(size * std::cos(off), along);
  return std::min(
      best, std::hypot(scalar_distance(law, graph, r, turned, snap, 0.0), size * std::sin(off)));
}

} // namespace hvi::solver
