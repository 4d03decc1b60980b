// Where each product of two entries of G goes in H (stiffness.hpp).
#include "solver/inequality/stiffness.hpp"

#include <algorithm>

namespace hvi::solver {

StiffnessPattern::StiffnessPattern(const ContactPoints& points)
    : zero_(points.unknowns, points.unknowns), first_contribution_{0} {
  const SparseMatrix& g = points.g;
  const auto for_pairs = [&](const PointData& q, const auto& f) {
    for (int a = 0; a < q.rows; ++a)
      for (int b = 0; b < q.rows; ++b)
        for (SparseMatrix::InnerIterator i(g, q.first + a); i; ++i)
          for (SparseMatrix::InnerIterator j(g, q.first + b); j; ++j)
            f(static_cast<int>(i.col()), static_cast<int>(j.col()), 3 * a + b,
              q.weight * q.share[a] * i.value() * j.value());
  };
  std::vector<Eigen::Triplet<double>> pattern;
  for (const PointData& q : points.data)
    for_pairs(q, [&](int i, int j, int, double) { pattern.emplace_back(i, j, 0.0); });
  zero_.setFromTriplets(pattern.begin(), pattern.end());
  for (const PointData& q : points.data) {
    for_pairs(q, [&](int i, int j, int entry, double coefficient) {
      const int* begin = zero_.innerIndexPtr() + zero_.outerIndexPtr()[i];
      const int* end = zero_.innerIndexPtr() + zero_.outerIndexPtr()[i + 1];
      const auto value = static_cast<int>(std::lower_bound(begin, end, j) - zero_.innerIndexPtr());
      contributions_.push_back({value, entry, coefficient});
    });
    first_contribution_.push_back(static_cast<int>(contributions_.size()));
  }
}

void StiffnessPattern::clear(SparseMatrix& h) {
  std::fill(h.valuePtr(), h.valuePtr() + h.nonZeros(), 0.0);
}

void StiffnessPattern::assemble(const std::vector<SmallMatrix>& d, SparseMatrix& h) const {
  clear(h);
  for (int p = 0; p < static_cast<int>(d.size()); ++p) add(p, d[p], h);
}

} // namespace hvi::solver
