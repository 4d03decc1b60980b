// The unknowns of each point, and where their products go in H (stiffness.hpp).
#include "solver/inequality/stiffness.hpp"

#include <algorithm>
#include <array>

namespace hvi::solver {

StiffnessPattern::StiffnessPattern(const ContactPoints& points)
    : points_(points), zero_(points.unknowns, points.unknowns) {
  std::vector<std::vector<int>> unknowns;
  std::vector<Eigen::Triplet<double>> pattern;
  for (const PointData& q : points.data) {
    unknowns.push_back(take(q));
    for (const int i : unknowns.back())
      for (const int j : unknowns.back()) pattern.emplace_back(i, j, 0.0);
  }
  zero_.setFromTriplets(pattern.begin(), pattern.end());
  for (const auto& of_point : unknowns)
    for (const int j : of_point)
      for (const int i : of_point) {
        const int* begin = zero_.innerIndexPtr() + zero_.outerIndexPtr()[i];
        const int* end = zero_.innerIndexPtr() + zero_.outerIndexPtr()[i + 1];
        places_.push_back(
            static_cast<int>(std::lower_bound(begin, end, j) - zero_.innerIndexPtr()));
      }
}

/// Notes what the point sees; returns the unknowns that it touches.
std::vector<int> StiffnessPattern::take(const PointData& q) {
  DenseRows rows = dense_rows(points_.g, q.first, q.rows);
  const std::size_t columns = rows.unknowns.size(),
                    before = seen_.empty() ? 0 : seen_.back().columns;
  const std::size_t first_place = seen_.empty() ? 0 : seen_.back().first_place + before * before;
  seen_.push_back({columns, g_.size(), first_place});
  g_.insert(g_.end(), rows.g.data(), rows.g.data() + rows.g.size());
  return std::move(rows.unknowns);
}

void StiffnessPattern::add(int p, std::span<const double> d, SparseMatrix& h) const {
  const PointData& q = points_[p];
  const Seen& seen = seen_[static_cast<std::size_t>(p)];
  const double* const g = g_.data() + seen.first_g;
  const int* place = places_.data() + seen.first_place;
  double* const values = h.valuePtr();
  std::array<double, slot::most_arguments> force; // of column j, weighted
  for (std::size_t j = 0; j < seen.columns; ++j) {
    const double* const of_j = g + j * static_cast<std::size_t>(q.rows);
    for (int a = 0; a < q.rows; ++a) {
      double sum = 0.0;
      for (int b = 0; b < q.rows; ++b) sum += d[q.rows * a + b] * of_j[b];
      force[a] = q.weight * q.share[a] * sum;
    }
    const double* of_i = g;
    for (std::size_t i = 0; i < seen.columns; ++i) {
      double sum = 0.0;
      for (int a = 0; a < q.rows; ++a) sum += *of_i++ * force[a];
      values[*place++] += sum;
    }
  }
}

void StiffnessPattern::clear(SparseMatrix& h) {
  std::fill(h.valuePtr(), h.valuePtr() + h.nonZeros(), 0.0);
}

void StiffnessPattern::assemble(const PointMatrices& d, SparseMatrix& h) const {
  clear(h);
  for (int p = 0; p < points_.size(); ++p) add(p, points_[p].block(d), h);
}

} // namespace hvi::solver
