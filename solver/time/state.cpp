// The numbering of the time loop; see state.hpp.
#include "solver/time/state.hpp"

#include "solver/time/interior.hpp"

#include <algorithm>
#include <utility>

namespace hvi::solver {
namespace {

/// Copies row `row` of `full` to the end of `out`, columns renumbered, dropped ones left out.
void append_row(const SparseMatrix& full, int row, const StateLayout& layout,
                std::vector<std::pair<int, double>>& scratch, std::vector<int>& columns,
                std::vector<double>& values) {
  scratch.clear();
  for (SparseMatrix::InnerIterator it(full, row); it; ++it)
    if (const auto entry = layout.entry_of[it.col()]; entry >= 0)
      scratch.emplace_back(entry, it.value());
  // Unknowns keep the order of the dofs; only imposed values, numbered last, can break it.
  std::sort(scratch.begin(), scratch.end());
  for (const auto& [column, value] : scratch) {
    columns.push_back(column);
    values.push_back(value);
  }
}

SparseMatrix from_rows(int n_columns, std::vector<int> starts, std::vector<int> columns,
                       std::vector<double> values) {
  return Eigen::Map<const SparseMatrix>(static_cast<int>(starts.size()) - 1, n_columns,
                                        static_cast<int>(values.size()), starts.data(),
                                        columns.data(), values.data());
}

template <class RowOf>
SparseMatrix restricted(const SparseMatrix& full, const StateLayout& layout, int n_rows,
                        RowOf&& row_of) {
  std::vector<int> starts{0}, columns;
  std::vector<double> values;
  std::vector<std::pair<int, double>> scratch;
  columns.reserve(full.nonZeros());
  values.reserve(full.nonZeros());
  for (int r = 0; r < n_rows; ++r) {
    append_row(full, row_of(r), layout, scratch, columns, values);
    starts.push_back(static_cast<int>(columns.size()));
  }
  return from_rows(layout.n_state, std::move(starts), std::move(columns), std::move(values));
}

} // namespace

void StateLayout::gather(const Vector& full, Vector& state) const {
  for (Eigen::Index i = 0; i < state.size(); ++i) state[i] = full[dof_of[i]];
}

void StateLayout::scatter(const Vector& state, Vector& full) const {
  if (interior) return interior->scatter(state, full);
  full.setZero();
  for (int i = 0; i < n_state; ++i) full[dof_of[i]] = state[i];
}

void StateLayout::scatter_observed(const Vector& state, Vector& full) const {
  if (interior) return interior->scatter_observed(state, full);
  scatter(state, full);
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
  return out;
}

SparseMatrix restrict_rows(const SparseMatrix& full, const StateLayout& layout) {
  return restricted(full, layout, layout.n_unknowns, [&](int r) { return layout.dof_of[r]; });
}

SparseMatrix restrict_columns(const SparseMatrix& full, const StateLayout& layout) {
  return restricted(full, layout, static_cast<int>(full.rows()), [](int r) { return r; });
}

} // namespace hvi::solver
