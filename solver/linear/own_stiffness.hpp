// How stiff a body is at an unknown, of matrices that keep all unknowns.
#pragma once

#include "solver/linear/sparse.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <span>

namespace hvi::solver {

/// |K_ii|; where that is 0, as of the pressure of an incompressible body, what the elimination of
/// the others leaves of it at most:  sum_j |K_ij K_ji| / |K_jj|  over those with a diagonal.
Vector own_stiffness(const SparseMatrix& k);

/// Roots of the largest stiffness of each of several unknowns. Rows divided by them, and values
/// times them, are roots of energies, whatever the units of the unknowns are.
class RowUnits {
public:
  /// `of_unknown`: by row, which one it is of, and is kept by reference; empty: there is one.
  RowUnits(const Vector& own_stiffness, std::span<const std::uint8_t> of_unknown);
  double operator[](Eigen::Index row) const { return root_[unknown(row)]; }

private:
  std::uint8_t unknown(Eigen::Index row) const {
    return of_unknown_.empty() ? 0 : of_unknown_[static_cast<std::size_t>(row)];
  }
  std::span<const std::uint8_t> of_unknown_;
  std::array<double, std::numeric_limits<std::uint8_t>::max() + 1> root_{};
};

} // namespace hvi::solver
