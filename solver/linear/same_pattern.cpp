#include "solver/linear/same_pattern.hpp"

#include <algorithm>

namespace hvi::solver {

bool same_pattern(const SparseMatrix& a, const SparseMatrix& b) {
  return a.isCompressed() && b.isCompressed() && a.rows() == b.rows() && a.cols() == b.cols() &&
         std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.rows() + 1, b.outerIndexPtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr());
}

} // namespace hvi::solver
