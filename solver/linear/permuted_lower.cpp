// See permuted_lower.hpp.
#include "solver/linear/permuted_lower.hpp"

#include "solver/common/failure.hpp"

namespace hvi::solver {

PermutedLower::PermutedLower(const SparseMatrix& k, std::span<const int> permutation)
    : entries_of_k_(static_cast<std::size_t>(k.nonZeros())),
      unknown_(permutation.begin(), permutation.end()), position_(unknown_.size()) {
  const int n = static_cast<int>(unknown_.size());
  for (int j = 0; j < n; ++j) position_[unknown_[j]] = j;
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  auto& [start, row] = pattern_;
  start.reserve(unknown_.size() + 1);
  row.reserve((entries_of_k_ + unknown_.size()) / 2);
  for (int j = 0; j < n; ++j) { // row u of K holds, by symmetry, column u
    for (int at = outer[unknown_[j]]; at < outer[unknown_[j] + 1]; ++at)
      if (const int i = position_[inner[at]]; i >= j) row.push_back(i);
    start.push_back(static_cast<Long>(row.size()));
  }
}

void PermutedLower::assign(const SparseMatrix& k) {
  const int n = static_cast<int>(unknown_.size());
  bool same =
      k.rows() == n && k.isCompressed() && static_cast<std::size_t>(k.nonZeros()) == entries_of_k_;
  value_.resize(pattern_.row.size());
  diagonal_.assign(unknown_.size(), 0.0);
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  const double* values = k.valuePtr();
  std::size_t next = 0;
  for (int j = 0; j < n && same; ++j) {
    for (int at = outer[unknown_[j]]; at < outer[unknown_[j] + 1]; ++at) {
      const int i = position_[inner[at]];
      if (i < j) continue;
      same = next < pattern_.row.size() && pattern_.row[next] == i;
      if (!same) break;
      if (i == j) diagonal_[j] = values[at];
      value_[next++] = values[at];
    }
    same = same && next == static_cast<std::size_t>(pattern_.start[j + 1]);
  }
  if (!same)
    throw Failure(FailureKind::bad_value, {},
                  "the matrix to factor does not have the pattern that was analysed");
}

} // namespace hvi::solver
