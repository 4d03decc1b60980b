// Has the reduced problem one solution for every load? (engine.hpp)
#include "solver/inequality/engine.hpp"

#include <cmath>

namespace hvi::solver {

namespace {
/// Up to this size one more factor is cheap beside those of the steps.
constexpr int most_factored = 1500;
constexpr int power_iterations = 40;
} // namespace

/// All points soften as steeply as their law anywhere does: the incremental energy is convex for
/// every load iff S - G^T W M G is positive definite, its ratio lambda_max(S^-1 G^T W M G) below 1.
bool InequalityEngine::convex() {
  bool softens = false;
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    double m = 0.0;
    for (int k = 0; k < law.components(); ++k) m = std::max(m, law.component(k).m);
    if (law.components() > 1 || !std::isfinite(m)) return false;
    softens = softens || m > 0.0;
    d[p].fill(0.0);
    for (int i = 0; i < points[p].rows; ++i) d[p][4 * i] = -m;
  }
  if (!softens) return true;
  factored = false;
  assemble();
  if (!op.symmetric() || n <= most_factored) return op.factor(h, {});
  SparseMatrix softening = -h, none = h;
  for (int e = 0; e < none.nonZeros(); ++e) none.valuePtr()[e] = 0.0;
  if (!op.factor(none, {})) return false;
  Vector x = Vector::Ones(n), y(n);
  double ratio = 0.0;
  for (int k = 0; k < power_iterations; ++k) {
    const Vector b = softening * x;
    op.solve(b, y);
    const double size = y.lpNorm<Eigen::Infinity>();
    if (!(size > 0.0)) return true;
    ratio = b.dot(y) > 0.0 ? y.dot(softening * y) / b.dot(y) : 0.0; // Rayleigh: from below
    x = y / size;
  }
  return ratio < 1.0;
}

} // namespace hvi::solver
