// An extreme eigenvalue of a large symmetric map, by Lanczos' method.
#pragma once

#include "solver/linear/sparse.hpp"

#include <cstdint>
#include <functional>
#include <optional>

namespace hvi::solver {

/// A map T that is symmetric in the inner product  x . B y,  B positive definite.
struct SymmetricMap {
  Eigen::Index n = 0;
  std::function<Vector(const Vector& v, const Vector& bv)> apply; ///< T v, of v and B v
  std::function<Vector(const Vector& v)> metric;                  ///< B v
};

enum class End : std::uint8_t { least, largest };

/// The eigenvalue of T at this end, with a residual of `error` relative to it. Nothing where the
/// iteration does not converge.
///
/// With thick restarts (K. Wu, H. Simon, Thick-restart Lanczos method for large symmetric
/// eigenvalue problems, SIAM J. Matrix Anal. Appl. 22 (2000) 602-616). B v is kept beside each v,
/// so that a step costs one product of each kind, however often its vector is made orthogonal to
/// those before it.
std::optional<double> extreme_eigenvalue(const SymmetricMap& map, End end, double error);

} // namespace hvi::solver
