// See spmv.hpp.
#include "solver/linear/spmv.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// Rows of `Count` matrices at once; Count is a constant so that the inner loop has no branch.
template <int Count>
void multiply_rows(const Product* terms, bool accumulate, Vector& y) {
  const SparseMatrix& first = *terms[0].matrix;
  const int* outer = first.outerIndexPtr();
  const int* inner = first.innerIndexPtr();
  const double* value[Count];
  const double* x[Count];
  for (int t = 0; t < Count; ++t) {
    value[t] = terms[t].matrix->valuePtr();
    x[t] = terms[t].vector->data();
  }
  for (int row = 0; row < first.rows(); ++row) {
    double sum[Count] = {};
    for (int at = outer[row]; at < outer[row + 1]; ++at)
      for (int t = 0; t < Count; ++t) sum[t] += value[t][at] * x[t][inner[at]];
    double total = accumulate ? y[row] : 0.0;
    for (int t = 0; t < Count; ++t) total += terms[t].factor * sum[t];
    y[row] = total;
  }
}

} // namespace

bool same_pattern(const SparseMatrix& a, const SparseMatrix& b) {
  return a.isCompressed() && b.isCompressed() && a.rows() == b.rows() && a.cols() == b.cols() &&
         std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.rows() + 1, b.outerIndexPtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr());
}

void multiply(std::span<const Product> terms, Vector& y) {
  if (terms.empty()) {
    y.setZero();
    return;
  }
  y.resize(terms[0].matrix->rows());
  for (std::size_t from = 0; from < terms.size(); from += 4) {
    const Product* group = terms.data() + from;
    const bool accumulate = from > 0;
    switch (std::min<std::size_t>(4, terms.size() - from)) {
    case 1:
      multiply_rows<1>(group, accumulate, y);
      break;
    case 2:
      multiply_rows<2>(group, accumulate, y);
      break;
    case 3:
      multiply_rows<3>(group, accumulate, y);
      break;
    default:
      multiply_rows<4>(group, accumulate, y);
      break;
    }
  }
}

BackwardError backward_error(const SparseMatrix& k, const Vector& x, const Vector& b, Vector* r) {
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  const double* value = k.valuePtr();
  if (r != nullptr) r->resize(k.rows());
  BackwardError worst;
  for (int row = 0; row < k.rows(); ++row) {
    double residual = b[row], scale = std::abs(b[row]);
    for (int at = outer[row]; at < outer[row + 1]; ++at) {
      const double term = value[at] * x[inner[at]];
      residual -= term;
      scale += std::abs(term);
    }
    if (r != nullptr) (*r)[row] = residual;
    if (residual == 0.0) continue;
    const double error = std::abs(residual) / scale;
    const bool lost = std::isnan(worst.error);
    if (!lost && !(error <= worst.error)) worst = {error, row}; // a NaN wins and stays
  }
  return worst;
}

} // namespace hvi::solver
