// Factors of rows and columns that bring the largest entries of a matrix near 1, whatever the units
// of its unknowns are.
#pragma once

#include "solver/linear/sparse.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

struct Scaling {
  Vector rows, columns;
};

/// The diagonal first: of [G C^T; C 0] all factors with rows s G s, s C t of size 1 at most are
/// alike to the passes that follow, also those that leave G far below C t = 1, where pivots are
/// rounding. So unknowns with a diagonal get 1 there, and the others what their largest couplings
/// with those ask for. The passes, each halving the exponent of what is too large or too small, are
/// those of P. A. Knight, D. Ruiz, B. Ucar, A symmetry preserving algorithm for matrix scaling,
/// INRIA research report 7552, 2012.
///
/// `for_each(f)` calls f(i, j, value) for the entries of an n x n matrix.
template <class ForEach>
Scaling scaling_of(Eigen::Index n, const ForEach& for_each) {
  constexpr int passes = 6;
  const auto from_largest = [](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 1.0; };
  Vector diagonal = Vector::Zero(n);
  for_each([&](auto i, auto j, double v) {
    if (i == j) diagonal[i] += std::abs(v);
  });
  Scaling out{diagonal.unaryExpr(from_largest), diagonal.unaryExpr(from_largest)};
  Vector rows = Vector::Zero(n), columns = rows;
  for_each([&](auto i, auto j, double v) {
    if (diagonal[i] == 0.0 && diagonal[j] != 0.0)
      rows[i] = std::max(rows[i], std::abs(v) * out.columns[j]);
    if (diagonal[j] == 0.0 && diagonal[i] != 0.0)
      columns[j] = std::max(columns[j], std::abs(v) * out.rows[i]);
  });
  for (Eigen::Index i = 0; i < n; ++i) {
    if (rows[i] > 0.0) out.rows[i] = 1.0 / rows[i];
    if (columns[i] > 0.0) out.columns[i] = 1.0 / columns[i];
  }
  for (int pass = 0; pass < passes; ++pass) {
    rows.setZero(), columns.setZero();
    for_each([&](auto i, auto j, double v) {
      const double size = std::abs(v) * out.rows[i] * out.columns[j];
      rows[i] = std::max(rows[i], size), columns[j] = std::max(columns[j], size);
    });
    out.rows = out.rows.cwiseProduct(rows.unaryExpr(from_largest));
    out.columns = out.columns.cwiseProduct(columns.unaryExpr(from_largest));
  }
  return out;
}

} // namespace hvi::solver
