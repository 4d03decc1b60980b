// Sparse patterns without triplets or sorting: the node graph has sorted rows already.
#include "solver/assembly/pattern.hpp"

#include <algorithm>
#include <limits>

namespace hvi::solver {

MatrixPattern::MatrixPattern(const NodeGraph& graph, int components, const DofSelection& dofs)
    : graph_(&graph), components_(components), dofs_(dofs) {
  if (dofs_.entry_of.empty())
    dofs_.n_rows = dofs_.n_columns = static_cast<int>(graph.offsets.size() - 1) * components;
  if (graph.neighbours.size() * components * components >
      std::size_t(std::numeric_limits<int>::max()))
    throw Failure(FailureKind::limit, Origin{},
                  "the matrix has more than 2^31 entries; the mesh is too fine");
  zeros_.resize(dofs_.n_rows, dofs_.n_columns);
  count_columns();
  fill_columns();
}

/// Where rows begin, and in them the entries of each neighbour.
void MatrixPattern::count_columns() {
  const int n_nodes = static_cast<int>(graph_->offsets.size()) - 1;
  std::vector<int> with(n_nodes, 0), without(n_nodes, 0);
  whole_.resize(n_nodes);
  for (int i = 0; i < n_nodes; ++i) {
    for (int c = 0; c < components_; ++c) {
      const int e = entry(i, c);
      with[i] += e >= 0 && e < dofs_.n_rows;
      without[i] += e >= dofs_.n_rows;
    }
    whole_[i] = with[i] == components_;
  }
  with_row_.resize(graph_->neighbours.size());
  without_row_.resize(graph_->neighbours.size());
  row_start_.assign(static_cast<std::size_t>(n_nodes) * components_, -1);
  row_length_.resize(n_nodes);
  const bool any_without = dofs_.n_columns > dofs_.n_rows;
  int* outer = zeros_.outerIndexPtr();
  int position = 0;
  for (int i = 0; i < n_nodes; ++i) {
    const auto first = graph_->offsets[i], past = graph_->offsets[i + 1];
    int length = 0;
    for (auto k = first; k < past; ++k) {
      with_row_[k] = length;
      length += with[graph_->neighbours[k]];
    }
    for (auto k = first; k < past && any_without; ++k) {
      without_row_[k] = length;
      length += without[graph_->neighbours[k]];
    }
    row_length_[i] = length;
    for (int c = 0; c < components_; ++c)
      if (const int e = entry(i, c); e >= 0 && e < dofs_.n_rows) {
        row_start_[i * components_ + c] = outer[e] = position;
        position += length;
      }
  }
  outer[dofs_.n_rows] = position;
}

void MatrixPattern::fill_columns() {
  const int entries = zeros_.outerIndexPtr()[dofs_.n_rows];
  zeros_.resizeNonZeros(entries);
  std::fill_n(zeros_.valuePtr(), entries, 0.0);
  int* const inner = zeros_.innerIndexPtr();
  const int n_nodes = static_cast<int>(graph_->offsets.size()) - 1;
  for (int i = 0; i < n_nodes; ++i) {
    const int* first_row = nullptr; // of the node: its others have the same columns
    for (int c = 0; c < components_; ++c) {
      const int start = row_start_[i * components_ + c];
      if (start < 0) continue;
      int* const row = inner + start;
      if (first_row != nullptr)
        std::copy_n(first_row, row_length_[i], row);
      else
        fill_row(i, row), first_row = row;
    }
  }
}

void MatrixPattern::fill_row(int node, int* columns) const {
  for (auto k = graph_->offsets[node]; k < graph_->offsets[node + 1]; ++k) {
    const auto neighbour = graph_->neighbours[k];
    int* with = columns + with_row_[k];
    if (whole_[neighbour] != 0) { // its entries follow each other
      const int e = entry(neighbour, 0);
      for (int d = 0; d < components_; ++d) with[d] = e + d;
      continue;
    }
    int* without = columns + without_row_[k];
    for (int d = 0; d < components_; ++d)
      if (const int e = entry(neighbour, d); e >= 0) *(e < dofs_.n_rows ? with++ : without++) = e;
  }
}

void MatrixPattern::locate(std::span<const std::int32_t> nodes, std::vector<int>& edges) const {
  constexpr int short_row = 16;
  edges.resize(nodes.size() * nodes.size());
  int* edge = edges.data();
  const std::int32_t* const all = graph_->neighbours.data();
  for (const auto node : nodes) {
    const auto *first = all + graph_->offsets[node], *past = all + graph_->offsets[node + 1];
    for (const auto other : nodes) {
      const auto* place = past - first <= short_row ? std::find(first, past, other)
                                                    : std::lower_bound(first, past, other);
      *edge++ = static_cast<int>(place - all);
    }
  }
}

template <int Components>
void MatrixPattern::add_fixed(std::span<const std::int32_t> nodes, std::span<const int> edges,
                              const double* element, double* values) const {
  add_of(Components, nodes, edges, element, values);
}

/// Inlined where the number of components is known when this is compiled.
inline __attribute__((always_inline)) void
MatrixPattern::add_of(int components, std::span<const std::int32_t> nodes,
                      std::span<const int> edges, const double* element, double* values) const {
  const std::size_t n = nodes.size(), width = n * static_cast<std::size_t>(components);
  for (std::size_t i = 0; i < n; ++i)
    for (int c = 0; c < components; ++c, element += width) {
      const int start = row_start_[nodes[i] * components + c];
      if (start < 0) continue;
      double* const row = values + start;
      for (std::size_t j = 0; j < n; ++j) {
        const int edge = edges[i * n + j];
        const double* from = element + j * static_cast<std::size_t>(components);
        double* with = row + with_row_[edge];
        if (whole_[nodes[j]] != 0) {
          for (int d = 0; d < components; ++d) with[d] += from[d];
          continue;
        }
        double* without = row + without_row_[edge];
        for (int d = 0; d < components; ++d)
          if (const int e = entry(nodes[j], d); e >= 0)
            *(e < dofs_.n_rows ? with++ : without++) += from[d];
      }
    }
}

void MatrixPattern::add(std::span<const std::int32_t> nodes, std::span<const int> edges,
                        const double* element, double* values) const {
  switch (components_) {
  case 1:
    return add_fixed<1>(nodes, edges, element, values);
  case 2:
    return add_fixed<2>(nodes, edges, element, values);
  case 3:
    return add_fixed<3>(nodes, edges, element, values);
  default: // of several unknowns
    return add_of(components_, nodes, edges, element, values);
  }
}

void add_scaled(SparseMatrix& into, double alpha, const SparseMatrix& matrix) {
  if (into.rows() != matrix.rows() || into.cols() != matrix.cols()) {
    throw std::invalid_argument("add_scaled: the matrices have different sizes");
  }
  const int* columns = into.innerIndexPtr();
  for (Eigen::Index row = 0; row < matrix.outerSize(); ++row) {
    int to = into.outerIndexPtr()[row];
    const int past = into.outerIndexPtr()[row + 1];
    for (int from = matrix.outerIndexPtr()[row]; from < matrix.outerIndexPtr()[row + 1]; ++from) {
      const int column = matrix.innerIndexPtr()[from];
      while (to < past && columns[to] < column) {
        ++to;
      }
      if (to == past || columns[to] != column) {
        throw std::invalid_argument("add_scaled: an entry is outside the pattern");
      }
      into.valuePtr()[to] += alpha * matrix.valuePtr()[from];
    }
  }
}

} // namespace hvi::solver
