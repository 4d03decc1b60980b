// A scalar law's graph over all arguments (curve_graph.hpp).
#include "solver/inequality/curve_graph.hpp"

#include "solver/common/numbers.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

CurveGraph::CurveGraph(const PreparedLaw& law) : law_(&law), odd_(law.radial()) {
  const LawGraph& g = law.graph();
  const auto count = static_cast<int>(g.breaks.size());
  if (odd_) {
    for (int b = count - 1; b >= 0; --b) {
      breaks_.push_back(-g.breaks[b]);
      left_.push_back(-g.right[b]), right_.push_back(-g.left[b]);
    }
    const double s = law.law().slope(g, 0, 0.0);
    breaks_.push_back(0.0), left_.push_back(-s), right_.push_back(s);
  }
  breaks_.insert(breaks_.end(), g.breaks.begin(), g.breaks.end());
  left_.insert(left_.end(), g.left.begin(), g.left.end());
  right_.insert(right_.end(), g.right.begin(), g.right.end());
  for (int i = 0; i < pieces(); ++i) {
    const int degree = g.smooth[own_piece(i)].degree;
    straight_.push_back(degree == 0 || degree == 1);
  }
}

int CurveGraph::own_piece(int piece) const {
  const int half = law_->graph().pieces();
  if (!odd_) return piece;
  return piece >= half ? piece - half : half - 1 - piece;
}

double CurveGraph::low(int piece) const { return piece == 0 ? -infinity : breaks_[piece - 1]; }
double CurveGraph::high(int piece) const {
  return piece + 1 == pieces() ? infinity : breaks_[piece];
}

void CurveGraph::slope(int piece, double z, double& s, double& d) const {
  const double inside = std::clamp(z, low(piece), high(piece));
  const bool negative = odd_ && piece < law_->graph().pieces();
  const double sign = negative ? -1.0 : 1.0;
  law_->law().slope_and_curvature(law_->graph(), own_piece(piece), sign * inside, s, d);
  if (!std::isfinite(d)) d = 0.0;
  s = sign * s + d * (z - inside);
}

double CurveGraph::potential(int piece, double z) const {
  const bool negative = odd_ && piece < law_->graph().pieces();
  return law_->law().potential(law_->graph(), own_piece(piece), negative ? -z : z);
}

double CurveGraph::least_curvature(int piece, double low, double high) const {
  const bool negative = odd_ && piece < law_->graph().pieces();
  const auto range = law_->law().curvature_range(law_->graph(), own_piece(piece),
                                                 negative ? -high : low, negative ? -low : high);
  return range.exact ? range.low - 1e-12 * std::abs(range.low) : -infinity;
}

int CurveGraph::engine_state(int place) const {
  const int i = place / 2, half = law_->graph().pieces();
  if (!odd_) return place;
  if (place % 2 == 0) return 2 * own_piece(i);
  if (i == half - 1) return -1; // at the origin
  return i >= half ? place - 2 * half : 2 * (half - 2 - i) + 1;
}

int CurveGraph::component(int place) const {
  return law_->component_of_piece(std::max(engine_state(place), 0) / 2);
}

} // namespace hvi::solver
