// Superpotentials (law.hpp): the public face of the graph builder.
#include "solver/law/law.hpp"

#include "solver/common/numbers.hpp"
#include "solver/law/builder.hpp"
#include "solver/law/descent.hpp"

#include <cmath>

namespace hvi::solver {

namespace {
/// What a run may spend on a law; `check` takes more (known_constants.hpp).
constexpr ProofEffort small_effort{1000, 1e-3, 60};
} // namespace

struct Law::Impl {
  LawSpec spec;
  GraphBuilder builder;
  bool on_x, on_t;

  explicit Impl(LawSpec s)
      : spec(std::move(s)), builder(spec),
        on_x(spec.expression.depends_on_any(slot::x(0), slot::x(2) + 1) || bound_varies()),
        on_t(spec.expression.depends_on(slot::t) || bound_varies()) {}
  bool bound_varies() const {
    return !spec.coupled.empty() || !spec.readings.empty() || !spec.states.empty();
  }
  const SmoothFunction& function(const LawGraph& g, int piece) const {
    return builder.function(g.functions[piece]);
  }
};

Law::Law(LawSpec spec) : impl_(std::make_unique<Impl>(std::move(spec))) {
  if (!impl_->on_x && !impl_->on_t) graph(Point{}, 0.0);
}
Law::~Law() = default;
Law::Law(Law&&) noexcept = default;
Law& Law::operator=(Law&&) noexcept = default;

const LawSpec& Law::spec() const { return impl_->spec; }
bool Law::depends_on_x() const { return impl_->on_x; }
bool Law::depends_on_t() const { return impl_->on_t; }
bool Law::coupled() const { return !impl_->spec.coupled.empty(); }
bool Law::reads() const { return !impl_->spec.readings.empty(); }
bool Law::reads_states() const { return !impl_->spec.states.empty(); }

LawGraph Law::graph(const Point& x, LawTime t) const { return impl_->builder.build(x, t); }

double Law::slope(const LawGraph& graph, int piece, double r) const {
  const auto& p = graph.smooth[piece];
  if (p.degree >= 0) return polynomial(p, r);
  const double v = impl_->function(graph, piece).slope(r, graph.x, graph.t);
  if (std::isfinite(v)) return v;
  // An expression undefined at the very break has its limit there.
  if (piece > 0 && r == graph.breaks[piece - 1]) return graph.right[piece - 1];
  if (piece + 1 < graph.pieces() && r == graph.breaks[piece]) return graph.left[piece];
  return impl_->spec.radial && piece == 0 && r == 0.0 ? graph.origin : v;
}

double Law::curvature(const LawGraph& graph, int piece, double r) const {
  double s, c;
  slope_and_curvature(graph, piece, r, s, c);
  return c;
}

void Law::slope_and_curvature(const LawGraph& graph, int piece, double r, double& s,
                              double& c) const {
  const auto& p = graph.smooth[piece];
  if (p.degree >= 0) {
    s = polynomial(p, r), c = polynomial_slope(p, r);
    return;
  }
  impl_->function(graph, piece).slope_and_curvature(r, graph.x, graph.t, s, c);
  if (!std::isfinite(s)) s = slope(graph, piece, r);
}

Law::CurvatureRange Law::curvature_range(const LawGraph& graph, int piece, double low,
                                         double high) const {
  if (const auto& p = graph.smooth[piece]; p.degree >= 0) {
    const SlopeRange range = polynomial_range(p, low, high);
    return {range.low, range.high, range.low_at, true};
  }
  const Descent down =
      smooth_descent(impl_->function(graph, piece), graph, low, high, small_effort);
  const bool proved = down.m.bounded_by_proof();
  return {-down.m.value(), infinity, down.at, proved};
}

std::optional<double> Law::steep_fall(const LawGraph& graph, int piece) const {
  if (graph.smooth[piece].degree >= 0) return {};
  return steep_end(impl_->function(graph, piece), graph,
                   piece_low(graph, piece, impl_->spec.radial), piece_high(graph, piece), -1.0);
}

LawConstants Law::constants(const Point& x, LawTime t) const {
  const LawGraph g = graph(x, t);
  const KnownConstants known = constants_of(impl_->builder, impl_->spec.radial, g, small_effort);
  LawConstants k;
  k.m = known.m.value(), k.c = known.c.value();
  k.jumps_down = known.jumps_down;
  k.steepest_ascent = known.steepest_ascent.value();
  k.slope_scale = known.slope_scale, k.worst_at = known.worst_at;
  k.exact = known.m.bounded_by_proof() && known.c.bounded_by_proof();
  k.clarke_regular = known.clarke_regular;
  k.convex = k.m <= 0.0;
  return k;
}

double Law::potential(const LawGraph& graph, int piece, double r) const {
  return primitive(impl_->spec, impl_->function(graph, piece), graph, piece, r) +
         graph.offsets[piece];
}

} // namespace hvi::solver
