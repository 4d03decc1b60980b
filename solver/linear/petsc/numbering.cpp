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

namespace {

/// These rows of arrays as they are.
Rows part_of(const HviPetscMatrix& a, int first, int end) {
  const int from = a.start[first], to = a.start[end];
  Rows out;
  out.start.assign(a.start + first, a.start + end + 1);
  for (int& start : out.start) start -= from;
  out.column.assign(a.column + from, a.column + to);
  out.value.assign(a.value + from, a.value + to);
  return out;
}

} // namespace

void WholeMatrix::need(const std::vector<int>& named) const {
  if (!is_dealt()) return;
  std::vector<int> missing;
  for (const int i : named)
    if (known_[i] < 0) missing.push_back(i);
  const Rows more = fetch_(missing);
  for (std::size_t k = 0; k < missing.size(); ++k) {
    known_[missing[k]] = fetched_.size();
    const int first = more.start[k], end = more.start[k + 1];
    fetched_.column.insert(fetched_.column.end(), more.column.begin() + first,
                           more.column.begin() + end);
    fetched_.value.insert(fetched_.value.end(), more.value.begin() + first,
                          more.value.begin() + end);
    fetched_.start.push_back(static_cast<int>(fetched_.column.size()));
  }
}

void WholeMatrix::changed() const {
  std::fill(known_.begin(), known_.end(), -1);
  fetched_ = Rows();
}

WholeMatrix::Row WholeMatrix::row(int i, Room& room) const {
  if (is_dealt()) {
    const int at = fetched_.start[known_[i]];
    return {fetched_.column.data() + at, fetched_.value.data() + at,
            fetched_.start[known_[i] + 1] - at};
  }
  const int own = numbering_ == nullptr ? i : numbering_->unknown_of(i);
  const int first = own < 0 ? 0 : a_.start[own], end = own < 0 ? 0 : a_.start[own + 1];
  if (numbering_ == nullptr) return {a_.column + first, a_.value + first, end - first};
  if (entries_of(i) == 0) return {nullptr, nullptr, 0}; // as most rows of laws are
  room.entries.clear();
  if (own < 0 && diagonal_ != 0.0) room.entries.emplace_back(i, diagonal_);
  for (int e = first; e < end; ++e)
    room.entries.emplace_back((*numbering_)[a_.column[e]], a_.value[e]);
  std::sort(room.entries.begin(), room.entries.end());
  room.column.clear(), room.value.clear();
  for (const auto& [column, value] : room.entries) {
    room.column.push_back(column);
    room.value.push_back(value);
  }
  return {room.column.data(), room.value.data(), static_cast<int>(room.column.size())};
}

double WholeMatrix::entry(int i, int j) const {
  if (is_dealt()) return petsc_module::entry(fetched_.view(), known_[i], j);
  if (numbering_ == nullptr) return petsc_module::entry(a_, i, j);
  const int row = numbering_->unknown_of(i), column = numbering_->unknown_of(j);
  if (row < 0 || column < 0) return i == j ? diagonal_ : 0.0;
  return petsc_module::entry(a_, row, column);
}

int WholeMatrix::entries_of(int i) const {
  const int own = numbering_ == nullptr ? i : numbering_->unknown_of(i);
  return own < 0 ? (diagonal_ != 0.0 ? 1 : 0) : a_.start[own + 1] - a_.start[own];
}

Rows WholeMatrix::part(int first, int end) const {
  if (const HviPetscMatrix* const whole = as_it_is()) return part_of(*whole, first, end);
  Rows out;
  out.start.reserve(static_cast<std::size_t>(end - first) + 1);
  for (int i = first; i < end; ++i) out.start.push_back(out.start.back() + entries_of(i));
  out.column.reserve(static_cast<std::size_t>(out.start.back()));
  out.value.reserve(static_cast<std::size_t>(out.start.back()));
  Room room;
  for (int i = first; i < end; ++i) {
    const Row own = row(i, room);
    out.column.insert(out.column.end(), own.column, own.column + own.size);
    out.value.insert(out.value.end(), own.value, own.value + own.size);
  }
  return out;
}

} // namespace hvi::petsc_module
