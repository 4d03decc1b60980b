// The numbers of hypothesis H(J) for one law: relaxed monotonicity and growth
// (known_constants.hpp).
#include "solver/common/numbers.hpp"
#include "solver/law/builder.hpp"
#include "solver/law/descent.hpp"
#include "solver/law/known_constants.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// One piece of a graph.
struct Piece {
  const SmoothFunction& function;
  const LawGraph& graph;
  const LawGraph::Smooth& smooth;
  double low, high;
  ProofEffort effort;

  bool unbounded() const { return !std::isfinite(low) || !std::isfinite(high); }
};

/// sup of an expression over a piece, at least 0.
Bracket supremum(const Expr& f, const Piece& p) {
  SupremumRange range{p.low, p.high, argument_scale(p.graph)};
  range.others.fixed = fixed_at(p.graph.x, p.graph.t);
  return Supremum(f)(range, {p.effort.of_growth, p.effort.digits, 0.0, 0.0}).value;
}

Descent descent(const Piece& p) {
  if (p.smooth.degree >= 0) return polynomial_descent(p.smooth, p.low, p.high);
  if (const auto at = steep_end(p.function, p.graph, p.low, p.high, -1.0))
    return {Bracket::exactly(infinity), *at};
  return smooth_descent(p.function, p.graph, p.low, p.high, p.effort);
}

Bracket ascent(const Piece& p) {
  if (p.smooth.degree >= 0)
    return Bracket::exactly(std::max(0.0, polynomial_range(p.smooth, p.low, p.high).high));
  const Expr rise = derivative(p.function.slope_expression(), slot::r);
  return steep_end(p.function, p.graph, p.low, p.high, 1.0) ? Bracket::exactly(infinity)
                                                            : supremum(rise, p);
}

/// sup |slope| / (1 + |r|) over one piece; infinite when the slope grows faster than r.
Bracket growth(const Piece& p) {
  const int degree = p.smooth.degree;
  if (degree >= 2 && p.unbounded()) return Bracket::exactly(infinity);
  if (degree == 0 || degree == 1) { // a quotient of affine functions is monotone: look at ends
    double c = p.unbounded() && degree == 1 ? std::abs(p.smooth.a[1]) : 0.0;
    for (const double r : {p.low, p.high, 0.0})
      if (std::isfinite(r) && r >= p.low && r <= p.high)
        c = std::max(c, std::abs(polynomial(p.smooth, r)) / (1.0 + std::abs(r)));
    return Bracket::exactly(c);
  }
  const Expr ratio = p.function.slope_expression() / (Expr(1.0) + abs(Expr::variable(slot::r)));
  return larger(supremum(ratio, p), supremum(-ratio, p));
}

} // namespace

/// A radial law's slope mu(r) xi / |xi| descends along xi as mu does, and across it by -mu(r) / r,
/// which is no more where mu(0) >= 0 and mu does not jump down: mu(r) >= mu(0) - m r.
KnownConstants constants_of(const GraphBuilder& builder, bool radial, const LawGraph& g,
                            ProofEffort effort) {
  KnownConstants k;
  const auto piece = [&](int i) {
    return Piece{builder.function(g.functions[i]),
                 g,
                 g.smooth[i],
                 piece_low(g, i, radial),
                 piece_high(g, i),
                 effort};
  };
  const int home = piece_of(g, 0.0);
  const double origin = radial ? g.origin
                        : g.smooth[home].degree >= 0
                            ? polynomial(g.smooth[home], 0.0)
                            : builder.function(g.functions[home]).slope(0.0, g.x, g.t);
  const GraphJumps jumps = jumps_of(g, radial, std::isfinite(origin) ? origin : 0.0);
  for (int i = 0; i < g.pieces(); ++i) {
    const Piece p = piece(i);
    const Descent down = descent(p);
    if (down.m.value() > k.m.value()) k.worst_at = down.at;
    k.m = larger(k.m, down.m);
    k.steepest_ascent = larger(k.steepest_ascent, ascent(p));
    k.c = larger(k.c, growth(p));
  }
  if (jumps.down) k.m = Bracket::exactly(infinity), k.worst_at = jumps.down_at;
  k.jumps_down = jumps.down;
  if (jumps.unbounded) k.c = Bracket::exactly(infinity);
  if (jumps.up) k.steepest_ascent = Bracket::exactly(infinity);
  k.slope_scale = jumps.slope_scale;
  // j is regular where its slope jumps up, -j where it jumps down; with both kinds neither is.
  k.clarke_regular = !(jumps.up && jumps.down);
  return k;
}

KnownConstants known_constants(const Law& law, const Point& x, LawTime t, ProofEffort effort) {
  const LawSpec spec = law.spec();
  const GraphBuilder builder(spec);
  return constants_of(builder, spec.radial, builder.build(x, t), effort);
}

} // namespace hvi::solver
