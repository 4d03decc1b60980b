// See law_curves.hpp.
#include "lang/law_curves.hpp"

#include "solver/kernel/slot.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::lang {
namespace {

using draw::Spot;
constexpr int samples_a_piece = 48;

/// Arguments worth showing: half as much again as the breaks span.
std::pair<double, double> window_of(const solver::LawGraph& graph, bool radial) {
  double low = 0.0, high = 0.0;
  for (const double b : graph.breaks) low = std::min(low, b), high = std::max(high, b);
  const double size = high > low ? high - low : 1.0;
  return {radial ? 0.0 : low - 0.5 * size, high + 0.5 * size};
}

bool bounded(double slope) { return std::abs(slope) < solver::unbounded_slope / 10.0; }

/// Slopes without bound become 1.25 of the largest other one.
void cut(std::vector<Spot>& curve) {
  double largest = 0.0;
  for (const Spot& p : curve)
    if (bounded(p[1])) largest = std::max(largest, std::abs(p[1]));
  if (largest == 0.0) largest = 1.0;
  for (Spot& p : curve) p[1] = std::clamp(p[1], -1.25 * largest, 1.25 * largest);
}

} // namespace

std::vector<Spot> law_curve(const solver::LawSpec& spec, double t) {
  std::vector<Spot> out;
  try {
    const solver::Law law(spec);
    const solver::LawGraph graph = law.graph({}, {t, 1.0});
    const auto [low, high] = window_of(graph, spec.radial);
    if (spec.radial) out.push_back({0.0, 0.0});
    for (int piece = 0; piece < graph.pieces(); ++piece) {
      const double from = std::max(low, solver::piece_low(graph, piece, spec.radial));
      const double to = std::min(high, solver::piece_high(graph, piece));
      for (int k = 0; k <= samples_a_piece && to > from; ++k) {
        const double r = from + (to - from) * k / samples_a_piece;
        const auto at = static_cast<std::size_t>(piece);
        const bool first = k == 0 && piece > 0,
                   last = k == samples_a_piece && at < graph.breaks.size() && to < high;
        const double slope = first  ? graph.right[at - 1]
                             : last ? graph.left[at]
                                    : law.slope(graph, piece, r);
        if (first || last || bounded(slope)) out.push_back({r, slope}); // a wall ends the graph
      }
    }
  } catch (const solver::Failure&) {
    return {}; // of what it reads nothing is known here, and there it may be no law
  }
  cut(out);
  return out;
}

std::vector<Spot> kernel_curve(const solver::KernelSpec& kernel, double t0, double t) {
  std::vector<Spot> out;
  constexpr int samples = 200;
  for (int k = 1; k <= samples; ++k) { // not at zero, where a kernel may be singular
    const double lag = (t - t0) * k / samples;
    out.push_back({lag, solver::evaluate(kernel.expression, [&](solver::Slot s) {
                     return s == solver::slot::lag ? lag : s == solver::slot::t ? t : 0.0;
                   })});
  }
  return out;
}

} // namespace hvi::lang
