// The Lagrange elements P1 and P2.
#include "solver/fem/element.hpp"

#include <algorithm>

namespace hvi::solver {

int lagrange_size(int dim, int order) { return order == 1 ? dim + 1 : (dim + 1) * (dim + 2) / 2; }

const std::vector<std::array<int, 2>>& simplex_edges(int dim) {
  static const std::array<std::vector<std::array<int, 2>>, 4> edges{
      {{}, {{0, 1}}, {{0, 1}, {0, 2}, {1, 2}}, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}}};
  return edges[static_cast<std::size_t>(dim)];
}

void lagrange_values(int dim, int order, const Barycentric& point, double* values) {
  for (int k = 0; k <= dim; ++k) {
    values[k] = order == 1 ? point[k] : point[k] * (2.0 * point[k] - 1.0);
  }
  if (order == 1) {
    return;
  }
  int i = dim + 1;
  for (const auto& [a, b] : simplex_edges(dim)) {
    values[i++] = 4.0 * point[a] * point[b];
  }
}

void lagrange_slopes(int dim, int order, const Barycentric& point, double* slopes) {
  const int n = dim + 1;
  std::fill(slopes, slopes + lagrange_size(dim, order) * n, 0.0);
  for (int k = 0; k <= dim; ++k) {
    slopes[k * n + k] = order == 1 ? 1.0 : 4.0 * point[k] - 1.0;
  }
  if (order == 1) {
    return;
  }
  int i = n;
  for (const auto& [a, b] : simplex_edges(dim)) {
    slopes[i * n + a] = 4.0 * point[b];
    slopes[i * n + b] = 4.0 * point[a];
    ++i;
  }
}

} // namespace hvi::solver
