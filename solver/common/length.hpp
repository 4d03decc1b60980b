// The Euclidean norm of a few numbers.
#pragma once

#include <cmath>

namespace hvi::solver {

/// Of v[0] .. v[n - 1], of any size: no square overflows.
inline double length_of(const double* v, int n) {
  if (n == 1) return std::abs(v[0]);
  if (n == 2) return std::hypot(v[0], v[1]);
  if (n == 3) return std::hypot(v[0], v[1], v[2]);
  double largest = 0.0, sum = 0.0;
  for (int i = 0; i < n; ++i) largest = std::fmax(largest, std::abs(v[i]));
  if (!(largest > 0.0) || std::isinf(largest)) return largest;
  for (int i = 0; i < n; ++i) sum += (v[i] / largest) * (v[i] / largest);
  return largest * std::sqrt(sum);
}

} // namespace hvi::solver
