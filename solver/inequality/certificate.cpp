// The certificate of a solve, from nothing but (c, xi), the laws and the operator (engine.hpp).
#include "solver/inequality/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

/// inclusion = max_p dist(xi_p, dj_p(z_p)) / max(|xi|_inf, slope scale of p's law)
/// residual  = max_i |S c + G^T W xi - r|_i / (|S||c| + |G^T W||xi| + |r|)_i
void InequalityEngine::certify() {
  update_z();
  snap_factor = certificate_snap;
  update_product();
  update_reach();
  report.residual = residual_ratio(xi);
  const double largest = n_rows > 0 ? xi.lpNorm<Eigen::Infinity>() : 0.0;
  report.inclusion = 0.0;
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    const Small zp = at(z, p), xp = at(xi, p);
    const double distance =
        inclusion_distance(law.law(), law.graph(), zp.data(), xp.data(), points[p].rows, snap(p));
    const double scale = std::max(largest, law.slope_scale());
    const double ratio = distance == 0.0 ? 0.0 : distance / scale;
    if (!(ratio <= report.inclusion)) report.inclusion = ratio, report.worst_point = p;
  }
  report.converged = report.residual <= options.tolerance && report.inclusion <= options.tolerance;
}

} // namespace hvi::solver
