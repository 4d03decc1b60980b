// Entries of a sparse matrix next to their mirror images: is it symmetric? Without a transpose.
#pragma once

#include "solver/linear/sparse.hpp"

#include <vector>

namespace hvi::solver {

/// pair(i, j, a_ij, a_ji) for all i > j with an entry at one of the two places; the other one may
/// be missing (0). False as soon as a pair is. Columns beyond the rows are left out. The rows must
/// be sorted: then the mirror images of the entries left of the diagonal come up one after the
/// other.
template <class Pair>
bool all_mirror_pairs(const SparseMatrix& a, Pair&& pair) {
  const int* start = a.outerIndexPtr();
  const int* column = a.innerIndexPtr();
  const double* value = a.valuePtr();
  const int n = static_cast<int>(a.rows());
  std::vector<int> next(start, start + n); // the first entry of each row that had no partner yet
  // Entries of row j up to column i that no row asked for are alone right of the diagonal.
  const auto pass = [&](int j, int i) {
    for (; next[j] < start[j + 1] && column[next[j]] < i; ++next[j])
      if (column[next[j]] > j && !pair(column[next[j]], j, 0.0, value[next[j]])) return false;
    return true;
  };
  for (int i = 0; i < n; ++i)
    for (int at = start[i]; at < start[i + 1] && column[at] < i; ++at) {
      const int j = column[at];
      if (!pass(j, i)) return false;
      const bool both = next[j] < start[j + 1] && column[next[j]] == i;
      if (!pair(i, j, value[at], both ? value[next[j]++] : 0.0)) return false;
    }
  for (int j = 0; j < n; ++j)
    if (!pass(j, n)) return false;
  return true;
}

} // namespace hvi::solver
