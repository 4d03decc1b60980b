// Points on straight pieces (straight_pieces.hpp).
#include "solver/inequality/straight_pieces.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

bool StraightPieces::possible(const ContactPoints& points) {
  const auto straight = [](const PreparedLaw& law) {
    const auto& smooth = law.graph().smooth;
    return !law.radial() && !law.law().depends_on_t() &&
           std::all_of(smooth.begin(), smooth.end(),
                       [](const auto& piece) { return piece.degree == 0 || piece.degree == 1; });
  };
  const auto& laws = points.laws.all();
  return std::all_of(laws.begin(), laws.end(), straight) &&
         std::all_of(points.data.begin(), points.data.end(),
                     [](const PointData& p) { return p.rows == 1; });
}

bool StraightPieces::take(int p, int state) {
  const PreparedLaw& law = points_.law(p);
  const LawGraph& g = law.graph();
  const int i = state / 2;
  const auto& smooth = g.smooth[i];
  const StraightPiece piece{piece_low(g, i, false),
                            piece_high(g, i),
                            smooth.centre,
                            smooth.a[0],
                            smooth.degree == 1 ? smooth.a[1] : 0.0,
                            law.component_of_piece(i)};
  if (!(std::abs(piece.s) < unbounded_slope) ||
      !(std::abs(piece.k) * points_[p].local <= PointData::far_stiffer))
    return false;
  pieces_[p] = piece;
  states_[p] = state;
  return true;
}

int StraightPieces::next_state(int p, double z) const {
  const StraightPiece& piece = pieces_[p];
  if (z >= piece.low && z <= piece.high) return stays;
  const PreparedLaw& law = points_.law(p);
  const LawGraph& g = law.graph();
  const int from = states_[p] / 2, to = piece_of(g, z);
  if (!std::isfinite(z) || law.component_of_piece(to) != piece.component) return unreachable;
  for (int b = std::min(from, to); b < std::max(from, to); ++b)
    if (g.left[b] != g.right[b]) return unreachable; // it may have to stay at the jump
  return 2 * to;
}

void StraightPieces::multipliers(const Vector& z, Vector& xi) const {
  for (int p = 0; p < points_.size(); ++p) {
    const StraightPiece& piece = pieces_[p];
    xi[points_[p].first] = piece.s + piece.k * (z[points_[p].first] - piece.centre);
  }
}

void StraightPieces::times_stiffness(const Vector& dz, Vector& out) const {
  for (int p = 0; p < points_.size(); ++p)
    out[points_[p].first] = pieces_[p].k * dz[points_[p].first];
}

} // namespace hvi::solver
