// See numbering.hpp.
#include "solver/linear/petsc/numbering.hpp"

#include <algorithm>

namespace hvi::petsc_module {

double entry(const HviPetscMatrix& a, int row, int column) {
  const int *begin = a.column + a.start[row], *end = a.column + a.start[row + 1];
  const int* at = std::lower_bound(begin, end, column);
  return at != end && *at == column ? a.value[at - a.column] : 0.0;
}

Numbering::Numbering(const HviPetscUnknowns& of, int n, const Partition& partition)
    : nodes_(of.nodes), components_(of.components), same_(n == of.nodes * of.components),
      counts_(partition.counts) {
  for (int& count : counts_) count *= components_;
  place_.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    const int node = partition.place.empty() ? of.node[i] : partition.place[of.node[i]];
    place_[i] = node * components_ + of.component[i];
    same_ = same_ && place_[i] == i;
  }
  if (same_) {
    place_ = {};
    return;
  }
  unknown_.assign(static_cast<std::size_t>(size()), -1);
  for (int i = 0; i < n; ++i) unknown_[place_[i]] = i;
}

Rows Numbering::rows_of(const HviPetscMatrix& a, double diagonal) const {
  const std::size_t n_entries = static_cast<std::size_t>(a.start[a.rows]) +
                                (diagonal != 0.0 ? static_cast<std::size_t>(size() - a.rows) : 0);
  Rows out;
  out.start.reserve(static_cast<std::size_t>(size()) + 1);
  out.column.reserve(n_entries);
  out.value.reserve(n_entries);
  std::vector<std::pair<int, double>> row;
  for (int p = 0; p < size(); ++p) {
    const int i = same_ ? p : unknown_[p];
    row.clear();
    if (i < 0 && diagonal != 0.0) row.emplace_back(p, diagonal);
    for (int e = i < 0 ? 0 : a.start[i]; i >= 0 && e < a.start[i + 1]; ++e)
      row.emplace_back((*this)[a.column[e]], a.value[e]);
    std::sort(row.begin(), row.end());
    for (const auto& [column, value] : row) {
      out.column.push_back(column);
      out.value.push_back(value);
    }
    out.start.push_back(static_cast<int>(out.column.size()));
  }
  return out;
}

void Numbering::refresh(const HviPetscMatrix& a, double diagonal, Rows& rows) const {
  const Rows now = rows_of(a, diagonal);
  std::copy(now.value.begin(), now.value.end(), rows.value.begin());
}

void Numbering::spread(const double* x, double* out) const {
  if (same_) {
    std::copy_n(x, size(), out);
    return;
  }
  for (int p = 0; p < size(); ++p) out[p] = unknown_[p] < 0 ? 0.0 : x[unknown_[p]];
}

void Numbering::collect(const double* x, double* out) const {
  if (same_) {
    std::copy_n(x, size(), out);
    return;
  }
  for (int p = 0; p < size(); ++p)
    if (unknown_[p] >= 0) out[unknown_[p]] = x[p];
}

} // namespace hvi::petsc_module
