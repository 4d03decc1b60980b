// Sparse patterns from node graphs, element matrices into them, sums of matrices.
#pragma once

#include "solver/fem/space.hpp"

namespace hvi::solver {

/// The pattern of a graph with every node expanded to `components` dofs; values zero. Rows sorted.
/// Throws Failure(limit) when the entries do not fit 32-bit indices.
SparseMatrix make_pattern(const NodeGraph& graph, int components);

/// Adds element matrices to a matrix that make_pattern made from the same graph.
class ElementScatter {
public:
  ElementScatter(const NodeGraph& graph, int components, SparseMatrix& matrix);
  /// element[(i * components + c) * width + j * components + d], width = nodes * components, is
  /// the coupling of dofs (nodes[i], c) and (nodes[j], d).
  void add(std::span<const std::int32_t> nodes, const double* element);

private:
  const NodeGraph* graph_;
  int components_;
  double* values_;
};

} // namespace hvi::solver
