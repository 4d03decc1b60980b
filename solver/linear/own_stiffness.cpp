// See own_stiffness.hpp.
#include "solver/linear/own_stiffness.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

Vector own_stiffness(const SparseMatrix& k) {
  const Vector diagonal = k.diagonal().cwiseAbs();
  Vector out = diagonal;
  for (int i = 0; i < k.rows(); ++i) {
    if (diagonal[i] > 0.0) continue;
    for (SparseMatrix::InnerIterator it(k, i); it; ++it)
      if (const double of_other = diagonal[it.col()]; of_other > 0.0)
        out[i] += std::abs(it.value() * k.coeff(static_cast<int>(it.col()), i)) / of_other;
  }
  return out;
}

RowUnits::RowUnits(const Vector& own_stiffness, std::span<const std::uint8_t> of_unknown)
    : of_unknown_(of_unknown) {
  for (Eigen::Index i = 0; i < own_stiffness.size(); ++i)
    root_[unknown(i)] = std::max(root_[unknown(i)], std::sqrt(own_stiffness[i]));
  for (double& root : root_)
    if (!(root > 0.0)) root = 1.0;
}

} // namespace hvi::solver
