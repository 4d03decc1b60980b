// Has the reduced problem one solution for every load? (engine.hpp)
#include "solver/inequality/engine.hpp"

#include <cmath>

namespace hvi::solver {

/// All points soften as steeply as their law anywhere does: the incremental energy is convex for
/// every load iff S - G^T W M G is positive definite.
bool InequalityEngine::convex() {
  bool softens = false;
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    double m = 0.0;
    bool proved = true; // a descent that was only seen proves nothing
    for (int k = 0; k < law.components(); ++k)
      m = std::max(m, law.component(k).m), proved = proved && law.component(k).proved;
    if (law.components() > 1 || !std::isfinite(m) || !proved) return false;
    softens = softens || m > 0.0;
    d[p].fill(0.0);
    for (int i = 0; i < points[p].rows; ++i) d[p][4 * i] = -m;
  }
  if (!softens) return true;
  if (!op.symmetric()) return false; // a factor of S says nothing of its sign then
  factored = false;
  assemble();
  return op.factor(h, {});
}

} // namespace hvi::solver
