// The numbering of the time loop; see state.hpp.
#include "solver/discrete/state.hpp"

#include "solver/discrete/discretisation.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace hvi::solver {
namespace {

void sort_rows(SparseMatrix& matrix) {
  std::vector<std::pair<int, double>> row;
  for (int r = 0; r < matrix.rows(); ++r) {
    const int first = matrix.outerIndexPtr()[r], past = matrix.outerIndexPtr()[r + 1];
    int* const column = matrix.innerIndexPtr();
    if (std::is_sorted(column + first, column + past)) continue;
    row.clear();
    for (int at = first; at < past; ++at) row.emplace_back(column[at], matrix.valuePtr()[at]);
    std::sort(row.begin(), row.end());
    for (int at = first; at < past; ++at)
      std::tie(column[at], matrix.valuePtr()[at]) = row[at - first];
  }
}

/// The entry of each column in the state; rows are row_of(0), row_of(1), ... of `full`.
template <class RowOf>
SparseMatrix restricted(const SparseMatrix& full, const StateLayout& layout, int n_rows,
                        RowOf&& row_of) {
  SparseMatrix out(n_rows, layout.n_state);
  const int* start = full.outerIndexPtr();
  const int* column = full.innerIndexPtr();
  const std::int32_t* entry_of = layout.entry_of.data();
  int* const out_start = out.outerIndexPtr();
  for (int r = 0; r < n_rows; ++r) {
    const int row = row_of(r);
    int count = 0;
    for (int at = start[row]; at < start[row + 1]; ++at) count += entry_of[column[at]] >= 0;
    out_start[r + 1] = out_start[r] + count;
  }
  out.resizeNonZeros(out_start[n_rows]);
  int* to_column = out.innerIndexPtr();
  double* to_value = out.valuePtr();
  for (int r = 0; r < n_rows; ++r) {
    const int row = row_of(r);
    for (int at = start[row]; at < start[row + 1]; ++at)
      if (const auto entry = entry_of[column[at]]; entry >= 0) {
        *to_column++ = entry;
        *to_value++ = full.valuePtr()[at];
      }
  }
  // Unknowns keep the order of the dofs; only imposed values, numbered last, can break it.
  if (layout.n_state > layout.n_unknowns) sort_rows(out);
  return out;
}

/// P^T A, or A, times P, where P takes a state to the full vector.
SparseMatrix added_up(const SparseMatrix& full, const StateLayout& layout, bool rows) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(full.nonZeros()));
  for (int r = 0; r < full.rows(); ++r) {
    const int row = rows ? layout.entry_of[r] : r;
    if (row < 0 || (rows && row >= layout.n_unknowns)) continue;
    for (SparseMatrix::InnerIterator it(full, r); it; ++it)
      if (const int column = layout.entry_of[it.col()]; column >= 0)
        entries.emplace_back(row, column, it.value());
  }
  SparseMatrix out(rows ? layout.n_unknowns : full.rows(), layout.n_state);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

} // namespace

void StateLayout::gather(const Vector& full, Vector& state) const {
  for (Eigen::Index i = 0; i < state.size(); ++i) state[i] = full[dof_of[i]];
}

void StateLayout::scatter(const Vector& state, Vector& full) const {
  full.setZero();
  for (int i = 0; i < n_state; ++i) full[dof_of[i]] = state[i];
  for (const DofLink& link : links) full[link.dof] = full[link.to];
}

StateLayout make_layout(const Space& space, const DofMap& dofs) {
  StateLayout out;
  out.n_unknowns = dofs.n_unknowns();
  out.n_dofs = space.n_dofs();
  out.dof_of.assign(dofs.free.begin(), dofs.free.end());
  if (!dofs.homogeneous)
    for (const auto& e : dofs.eliminated) out.dof_of.push_back(e.dof);
  out.n_state = static_cast<int>(out.dof_of.size());
  out.entry_of.assign(out.n_dofs, -1);
  for (int i = 0; i < out.n_state; ++i) out.entry_of[out.dof_of[i]] = i;
  out.links = dofs.links;
  for (const DofLink& link : out.links) out.entry_of[link.dof] = out.entry_of[link.to];
  return out;
}

SparseMatrix restrict_rows(const SparseMatrix& full, const StateLayout& layout) {
  if (!layout.links.empty()) return added_up(full, layout, true);
  return restricted(full, layout, layout.n_unknowns, [&](int r) { return layout.dof_of[r]; });
}

SparseMatrix restrict_columns(const SparseMatrix& full, const StateLayout& layout) {
  if (!layout.links.empty()) return added_up(full, layout, false);
  return restricted(full, layout, static_cast<int>(full.rows()), [](int r) { return r; });
}

Vector initial_state(const Problem& problem, const Discretisation& d, const StateLayout& layout) {
  Vector out = Vector::Zero(layout.n_state);
  const TimeSpec& time = problem.time;
  if (time.start)
    layout.gather(Eigen::Map<const Vector>(time.start->u.data(), d.space.n_dofs()), out);
  else if (!time.is_static && !time.initial.empty())
    layout.gather(interpolate(d.space, time.initial, time.grid.front(), time.origin), out);
  return out;
}

} // namespace hvi::solver
