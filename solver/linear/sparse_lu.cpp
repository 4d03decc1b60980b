// See sparse_lu.hpp. The rows of a are UMFPACK's columns: it has the factors of the transpose.
#include "solver/linear/sparse_lu.hpp"

#include "solver/common/out_of_memory.hpp"

#include <array>

namespace hvi::solver {

bool SparseLu::factor(const SparseMatrix& a) {
  const auto n = static_cast<SuiteSparse_long>(a.rows());
  numeric_.reset();
  if (n == 0) return true;
  std::vector<SuiteSparse_long> start{0}, column;
  value_.clear();
  for (int row = 0; row < a.rows(); ++row) {
    for (SparseMatrix::InnerIterator it(a, row); it; ++it)
      column.push_back(it.col()), value_.push_back(it.value());
    start.push_back(static_cast<SuiteSparse_long>(column.size()));
  }
  if (!symbolic_ || start != start_ || column != column_) {
    start_ = std::move(start), column_ = std::move(column);
    void* symbolic = nullptr;
    const auto status = umfpack_dl_symbolic(n, n, start_.data(), column_.data(), value_.data(),
                                            &symbolic, nullptr, nullptr);
    symbolic_.reset(symbolic);
    if (status == UMFPACK_ERROR_out_of_memory)
      throw OutOfMemory("no memory to analyse a matrix of {} unknowns", n);
    if (status < 0) return false; // an empty row
  }
  std::array<double, UMFPACK_INFO> info{};
  void* numeric = nullptr;
  const auto status = umfpack_dl_numeric(start_.data(), column_.data(), value_.data(),
                                         symbolic_.get(), &numeric, nullptr, info.data());
  numeric_.reset(numeric);
  if (status < 0) throw OutOfMemory("no memory to factor a matrix of {} unknowns", n);
  const bool regular = status == UMFPACK_OK && info[UMFPACK_RCOND] > 0.0; // false for NaN
  if (!regular) numeric_.reset();
  return regular;
}

Vector SparseLu::solve(const Vector& b) const {
  Vector x = b;
  if (numeric_)
    umfpack_dl_solve(UMFPACK_At, start_.data(), column_.data(), value_.data(), x.data(), b.data(),
                     numeric_.get(), nullptr, nullptr);
  return x;
}

SparseMatrix SparseLu::solve(const SparseMatrix& b) const {
  const Eigen::SparseMatrix<double, Eigen::ColMajor, int> columns = b;
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < columns.cols(); ++j) {
    if (columns.col(j).nonZeros() == 0) continue;
    const Vector x = solve(Vector(columns.col(j)));
    for (int i = 0; i < x.size(); ++i)
      if (x[i] != 0.0) entries.emplace_back(i, j, x[i]);
  }
  SparseMatrix out(b.rows(), b.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

int SparseLu::determinant_sign() const {
  if (!numeric_) return 0;
  double mantissa = 0.0, exponent = 0.0;
  if (umfpack_dl_get_determinant(&mantissa, &exponent, numeric_.get(), nullptr) < 0) return 0;
  return mantissa > 0.0 ? 1 : mantissa < 0.0 ? -1 : 0;
}

} // namespace hvi::solver
