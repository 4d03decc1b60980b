// Sparse patterns without triplets or sorting: the node graph has sorted rows already.
#include "solver/assembly/pattern.hpp"

#include "solver/assembly/assembly.hpp"

#include <algorithm>
#include <limits>

namespace hvi::solver {

SparseMatrix make_pattern(const NodeGraph& graph, int components) {
  const std::size_t n_nodes = graph.offsets.size() - 1;
  const std::size_t entries = graph.neighbours.size() * components * components;
  if (entries > std::size_t(std::numeric_limits<int>::max())) {
    throw Failure(FailureKind::limit, Origin{},
                  "the matrix has more than 2^31 entries; the mesh is too fine");
  }
  const auto size = static_cast<Eigen::Index>(n_nodes * components);
  SparseMatrix matrix(size, size);
  matrix.resizeNonZeros(static_cast<Eigen::Index>(entries));
  int* outer = matrix.outerIndexPtr();
  int* inner = matrix.innerIndexPtr();
  int position = 0;
  for (std::size_t i = 0; i < n_nodes; ++i) {
    for (int c = 0; c < components; ++c) {
      *outer++ = position;
      for (auto k = graph.offsets[i]; k < graph.offsets[i + 1]; ++k) {
        for (int d = 0; d < components; ++d) {
          inner[position++] = graph.neighbours[k] * components + d;
        }
      }
    }
  }
  *outer = position;
  std::fill_n(matrix.valuePtr(), entries, 0.0);
  return matrix;
}

ElementScatter::ElementScatter(const NodeGraph& graph, int components, SparseMatrix& matrix)
    : graph_(&graph), components_(components), values_(matrix.valuePtr()) {}

void ElementScatter::add(std::span<const std::int32_t> nodes, const double* element) {
  const std::size_t n = nodes.size(), m = components_, width = n * m;
  for (std::size_t i = 0; i < n; ++i) {
    const auto first = graph_->offsets[nodes[i]], last = graph_->offsets[nodes[i] + 1];
    const auto row = graph_->neighbours.begin() + first;
    const std::size_t length = last - first;
    double* values = values_ + std::size_t(first) * m * m;
    for (std::size_t j = 0; j < n; ++j) {
      const auto place = std::lower_bound(row, graph_->neighbours.begin() + last, nodes[j]) - row;
      for (std::size_t c = 0; c < m; ++c) {
        double* to = values + c * length * m + place * m;
        const double* from = element + (i * m + c) * width + j * m;
        for (std::size_t d = 0; d < m; ++d) {
          to[d] += from[d];
        }
      }
    }
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
