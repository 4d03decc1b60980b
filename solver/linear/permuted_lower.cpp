// See permuted_lower.hpp.
#include "solver/linear/permuted_lower.hpp"

#include "solver/common/failure.hpp"

namespace hvi::solver {

PermutedLower::PermutedLower(const SparseMatrix& k, std::span<const int> permutation)
    : entries_of_k_(static_cast<std::size_t>(k.nonZeros())),
      unknown_(permutation.begin(), permutation.end()), position_(unknown_.size()) {
  const int n = static_cast<int>(unknown_.size());
  for (int j = 0; j < n; ++j) position_[unknown_[j]] = j;
  start_.reserve(unknown_.size() + 1);
  row_.reserve((entries_of_k_ + unknown_.size()) / 2 + 1);
  start_.push_back(0);
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  // By symmetry row u of K is column u: what of it stands at or below the diagonal, in any order.
  for (int j = 0; j < n; ++j) {
    for (int at = outer[unknown_[j]]; at < outer[unknown_[j] + 1]; ++at)
      if (const int i = position_[inner[at]]; i >= j) row_.push_back(i);
    start_.push_back(static_cast<Long>(row_.size()));
  }
}

void PermutedLower::assign(const SparseMatrix& k) {
  const int n = static_cast<int>(unknown_.size());
  bool same =
      k.rows() == n && k.isCompressed() && static_cast<std::size_t>(k.nonZeros()) == entries_of_k_;
  value_.resize(row_.size());
  diagonal_.assign(unknown_.size(), 0.0);
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  const double* values = k.valuePtr();
  std::size_t next = 0;
  for (int j = 0; j < n && same; ++j) {
    for (int at = outer[unknown_[j]]; at < outer[unknown_[j] + 1]; ++at) {
      const int i = position_[inner[at]];
      if (i < j) continue;
      same = next < row_.size() && row_[next] == i;
      if (!same) break;
      if (i == j) diagonal_[j] = values[at];
      value_[next++] = values[at];
    }
    same = same && next == static_cast<std::size_t>(start_[j + 1]);
  }
  if (!same)
    throw Failure(FailureKind::bad_value, {},
                  "the matrix to factor does not have the pattern that was analysed");
}

cholmod_sparse PermutedLower::view() {
  cholmod_sparse a{};
  a.nrow = a.ncol = unknown_.size();
  a.nzmax = row_.size();
  a.p = start_.data();
  a.i = row_.data();
  a.x = value_.data();
  a.stype = -1;
  a.itype = CHOLMOD_LONG;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 0;
  a.packed = 1;
  return a;
}

} // namespace hvi::solver
