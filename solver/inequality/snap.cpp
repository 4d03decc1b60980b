// The scale of rounding in the arguments (snap.hpp).
#include "solver/inequality/snap.hpp"

#include "solver/inequality/shared_scales.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

Snap::Snap(const ContactPoints& points) : points_(points), reach_(Vector::Zero(points.unknowns)) {}

/// reach_i = |c_i| + (|r_i| + |(S c)_i - S_ii c_i|) / S_ii: how far unknown i would go under the
/// forces of its own equation if the others were held; it does not vanish where all displacements
/// are rounding. A part of the largest reach is added: where nothing acts, the displacement is
/// rounding of the others.
void Snap::update(const Vector& c, const ForceBalance& balance, double factor_) {
  factor = factor_;
  const Vector &load = balance.load(), &s_c = balance.product.value();
  for (int i = 0; i < points_.unknowns; ++i) {
    const double own = points_.diagonal[i], stiffness = std::abs(own);
    reach_[i] = std::abs(c[i]);
    if (stiffness > 0.0)
      reach_[i] += (std::abs(load[i]) + std::abs(s_c[i] - own * c[i])) / stiffness;
  }
  const auto& of_unknown = points_.problem.of_unknown;
  if (of_unknown.empty()) {
    if (points_.unknowns > 0) reach_.array() += part_of_largest_reach * reach_.maxCoeff();
    return;
  }
  ByUnknown largest{};
  for (int i = 0; i < points_.unknowns; ++i)
    largest[of_unknown[i]] = std::max(largest[of_unknown[i]], reach_[i]);
  for (int i = 0; i < points_.unknowns; ++i)
    reach_[i] += part_of_largest_reach * largest[of_unknown[i]];
}

double Snap::operator()(int p) const {
  const PointData& q = points_[p];
  const ReducedProblem& problem = points_.problem;
  const Vector& known =
      problem.offset_size.size() == points_.rows ? problem.offset_size : problem.offset;
  double size = 0.0;
  for (int row = q.first; row < q.first + q.rows; ++row) {
    double sum = std::abs(known[row]);
    for (SparseMatrix::InnerIterator it(points_.g, row); it; ++it)
      sum += std::abs(it.value()) * reach_[it.col()];
    size = std::max(size, sum);
  }
  return factor * size;
}

} // namespace hvi::solver
