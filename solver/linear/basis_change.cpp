// See basis_change.hpp.
#include "solver/linear/basis_change.hpp"

#include <cmath>
#include <map>
#include <utility>

namespace hvi::solver {
namespace {

/// Entries below this part of what they are sums of are rounding.
constexpr double cancelled = 1e-13;

struct Sum {
  double value = 0.0, size = 0.0;
  void add(double term) { value += term, size += std::abs(term); }
};

/// T - 1 from the rows of T.
SparseMatrix without_identity(const std::vector<int>& replaced, const SparseMatrix& rows) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t r = 0; r < replaced.size(); ++r) {
    entries.emplace_back(replaced[r], replaced[r], -1.0);
    for (SparseMatrix::InnerIterator it(rows, static_cast<Eigen::Index>(r)); it; ++it)
      entries.emplace_back(replaced[r], static_cast<int>(it.col()), it.value());
  }
  SparseMatrix out(rows.cols(), rows.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

} // namespace

BasisChange::BasisChange(std::vector<int> replaced, SparseMatrix rows, SparseMatrix inverse)
    : replaced_(std::move(replaced)), rows_(std::move(rows)), inverse_(std::move(inverse)),
      deviation_(without_identity(replaced_, rows_)) {}

void BasisChange::to_old(Vector& x) const {
  const Vector values = rows_ * x;
  for (std::size_t r = 0; r < replaced_.size(); ++r)
    x[replaced_[r]] = values[static_cast<Eigen::Index>(r)];
}

void BasisChange::transposed(Vector& b) const {
  Vector values(static_cast<Eigen::Index>(replaced_.size()));
  for (std::size_t r = 0; r < replaced_.size(); ++r)
    values[static_cast<Eigen::Index>(r)] = std::exchange(b[replaced_[r]], 0.0);
  b.noalias() += rows_.transpose() * values;
}

SparseMatrix BasisChange::congruent(const SparseMatrix& k) const {
  const SparseMatrix half = k + SparseMatrix(k * deviation_);
  return half + SparseMatrix(SparseMatrix(deviation_.transpose()) * half);
}

SparseMatrix BasisChange::columns(const SparseMatrix& g) const {
  std::vector<int> row_of(static_cast<std::size_t>(g.cols()), -1);
  for (std::size_t r = 0; r < replaced_.size(); ++r)
    row_of[static_cast<std::size_t>(replaced_[r])] = static_cast<int>(r);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < g.rows(); ++i) {
    std::map<int, Sum> sums;
    for (SparseMatrix::InnerIterator it(g, i); it; ++it) {
      const int r = row_of[static_cast<std::size_t>(it.col())];
      if (r < 0)
        sums[static_cast<int>(it.col())].add(it.value());
      else
        for (SparseMatrix::InnerIterator of(rows_, r); of; ++of)
          sums[static_cast<int>(of.col())].add(it.value() * of.value());
    }
    for (const auto& [column, sum] : sums)
      if (std::abs(sum.value) > cancelled * sum.size) entries.emplace_back(i, column, sum.value);
  }
  SparseMatrix out(g.rows(), g.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

} // namespace hvi::solver
