// Has the reduced problem one solution for every load? (follow.hpp)
#include "solver/inequality/follow.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

/// All points soften as steeply as their law anywhere does: the incremental energy is convex for
/// every load iff S - G^T W M G is positive definite.
bool is_convex(const ContactPoints& points, const StiffnessPattern& pattern, LastFactor& factor) {
  bool softens = false;
  SparseMatrix h = pattern.zero();
  PointMatrices d = points.no_matrices();
  for (int p = 0; p < points.size(); ++p) {
    const PreparedLaw& law = points.law(p);
    double m = 0.0;
    bool proved = true; // a bound from samples proves nothing
    for (int k = 0; k < law.components(); ++k)
      m = std::max(m, law.component(k).m), proved = proved && law.component(k).proved;
    const Small& share = points[p].share;
    const bool mixed = std::ranges::any_of(share, [](double s) { return s != 1.0; });
    if (mixed || law.components() > 1 || !std::isfinite(m) || !proved) return false;
    softens = softens || m > 0.0;
    points[p].put_multiple(d, -m);
  }
  if (!softens) return true;
  pattern.assemble(d, h);
  // Where S is not symmetric, a factor does not show whether the sum is positive definite.
  return factor.op().symmetric() && factor.make_other(h) && factor.op().definite();
}

} // namespace hvi::solver
