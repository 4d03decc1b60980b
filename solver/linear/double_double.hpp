// Sums of products in about twice the precision of double, for residuals. Standard operations only,
// so that every processor gives the same bits.
#pragma once

#include "solver/linear/sparse.hpp"

#include <cmath>
#include <vector>

namespace hvi::solver {

/// high + low with |low| below half a unit in the last place of high.
///
/// TwoSum of Knuth and the product by a fused multiply-add, as in T. Ogita, S. M. Rump, S. Oishi,
/// Accurate sum and dot product, SIAM J. Sci. Comput. 26 (2005) 1955-1988, Algorithms 3.1 and 3.5.
struct DoubleDouble {
  double high = 0.0, low = 0.0;

  /// Adds a b, itself without any rounding.
  void add_product(double a, double b) {
    const double p = a * b;
    add(p);
    low += std::fma(a, b, -p);
  }
  void add(double b) {
    const double sum = high + b, part = sum - high;
    low += (high - (sum - part)) + (b - part);
    high = sum;
  }
  double value() const { return high + low; }
};

/// y_i -= sum_j A_ij x_j, and size_i += sum_j |A_ij x_j|.
inline void subtract_product(const SparseMatrix& a, const Vector& x, std::vector<DoubleDouble>& y,
                             Vector& size) {
  for (int i = 0; i < a.rows(); ++i)
    for (SparseMatrix::InnerIterator it(a, i); it; ++it) {
      y[static_cast<std::size_t>(i)].add_product(-it.value(), x[it.col()]);
      size[i] += std::abs(it.value() * x[it.col()]);
    }
}

} // namespace hvi::solver
