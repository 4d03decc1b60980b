// See matrix_rows.hpp.
#include "solver/linear/matrix_rows.hpp"

#include "solver/linear/own_stiffness.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

void HeldRows::apply_magnitude(const Vector& x, Vector& y) const {
  y.setZero(size());
  for (int i = 0; i < size(); ++i)
    for (SparseMatrix::InnerIterator it(a_, i); it; ++it)
      y[i] += std::abs(it.value() * x[it.col()]);
}

Vector HeldRows::own_stiffness() const { return hvi::solver::own_stiffness(a_); }

std::function<double(int)> HeldRows::whole_sizes(const Vector& x) const {
  return [this, &x](int i) {
    double own = 0.0, largest = 0.0;
    for (SparseMatrix::InnerIterator it(a_, i); it; ++it) {
      if (!of_unknown_.empty() && of_unknown_[it.col()] != of_unknown_[i]) continue;
      if (it.col() == i) own = std::abs(it.value());
      largest = std::max(largest, std::abs(x[it.col()]));
    }
    return own * largest;
  };
}

} // namespace hvi::solver
