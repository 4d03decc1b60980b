// The steepest descent of one piece of a law. Internal to solver/law.
#pragma once

#include "solver/law/known_constants.hpp"
#include "solver/law/smooth.hpp"

#include <optional>

namespace hvi::solver {

/// The steepest descent of a slope: sup of -slope', at least 0.
struct Descent {
  Bracket m;
  double at = 0.0; ///< an argument where it is (nearly) attained
};

/// Least and largest derivative of a polynomial slope on [low, high]; closed form.
struct SlopeRange {
  double low = 0.0, high = 0.0, low_at = 0.0;
};
SlopeRange polynomial_range(const LawGraph::Smooth& p, double low, double high);
Descent polynomial_descent(const LawGraph::Smooth& p, double low, double high);
/// What is below the rounding of the curvature at a few points counts as 0.
Descent smooth_descent(const SmoothFunction& f, const LawGraph& graph, double low, double high,
                       ProofEffort effort);

/// The end of a piece at which the slope rises (sign 1) or falls (sign -1) infinitely steeply, by
/// proof: as -sqrt(r) falls at 0.
std::optional<double> steep_end(const SmoothFunction& f, const LawGraph& graph, double low,
                                double high, double sign);

/// Where the slope of a graph jumps; for a radial law, whose slope at 0 is `origin`, also there.
struct GraphJumps {
  bool up = false, down = false;
  bool unbounded = false; ///< to an infinite slope, as unilateral contact
  double down_at = 0.0;
  double slope_scale = 0.0; ///< the largest finite limit at a break or at 0
};
GraphJumps jumps_of(const LawGraph& graph, bool radial, double origin);

/// A size for the arguments of a law: that of its breaks, at least 1.
double argument_scale(const LawGraph& graph);
/// A bracket whose upper end is not above rounding of `size` is 0.
Bracket without_rounding(const Bracket& b, double size);

/// The constants at one point, of a law whose graphs this builder makes.
class GraphBuilder;
KnownConstants constants_of(const GraphBuilder& builder, bool radial, const LawGraph& graph,
                            ProofEffort effort);

} // namespace hvi::solver
