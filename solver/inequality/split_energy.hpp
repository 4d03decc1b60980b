// The energy of a reduced problem, with a part of the body's given to the laws (least_energy.hpp).
#pragma once

#include "solver/inequality/point_energy.hpp"

#include <optional>

namespace hvi::solver {

/// With D taken from the body, the energy over that of the free body is, over a constant,
///
///     E(z) = shift + (z - b~)^T (C^-1 - D) (z - b~) / 2 + sum_p phi_p(z_p).
struct SplitEnergy {
  Vector d;                        ///< D
  DenseMatrix compliance;          ///< (C^-1 - D)^-1
  Vector b;                        ///< b~ = (1 - C D)^-1 b
  double shift;                    ///< E where phi = 0 and its multipliers are 0
  std::vector<PointEnergy> points; ///< with their shares d of D
};

/// Mostly for the points whose law is not convex. Nothing where no D leaves enough of the body.
std::optional<SplitEnergy> split_energy(const DenseMatrix& c, std::vector<PointEnergy> points,
                                        const Vector& b);

} // namespace hvi::solver
