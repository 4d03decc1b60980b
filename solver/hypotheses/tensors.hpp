// The tensor behind a form, point by point.
#pragma once

#include "solver/time/run.hpp"

#include <limits>

namespace hvi::solver {

/// Least eigenvalue over the mesh of the tensor C in  int C : eps(u) : eps(v)  (of the matrix in
/// int K grad u . grad v for scalars), and where; 0 where it has none in a
/// part of the body, infinite when the field has no such form at all.
/// Constant tensors are exact, others are looked at in the middle of every cell.
struct Ellipticity {
  double least = std::numeric_limits<double>::infinity();
  Point at{};
  Origin origin;
  bool varies = false;
};
Ellipticity ellipticity(const Problem& problem, const Discretisation& discretisation, int field);

} // namespace hvi::solver
