// Regula falsi with bisection (line_search.hpp).
#include "solver/inequality/line_search.hpp"

#include <cmath>

namespace hvi::solver {

double line_search(const std::function<double(double)>& slope) {
  const double s0 = slope(0.0);
  if (!(s0 < 0.0)) return 1.0;
  double low = 0.0, high = 1.0, s_low = s0, s_high = slope(1.0);
  if (s_high <= 0.3 * std::abs(s0)) return 1.0;
  for (int k = 0; k < 60; ++k) {
    const double falsi = low - s_low * (high - low) / (s_high - s_low);
    const double t = k % 2 == 0 ? falsi : 0.5 * (low + high);
    const double st = slope(t);
    if (std::abs(st) <= 0.3 * std::abs(s0)) return t;
    (st < 0.0 ? low : high) = t;
    (st < 0.0 ? s_low : s_high) = st;
  }
  return low > 0.0 ? low : high;
}

} // namespace hvi::solver
