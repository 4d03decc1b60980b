// Sparse patterns from node graphs, element matrices into them, sums of matrices.
#pragma once

#include "solver/assembly/assembly.hpp"

namespace hvi::solver {

/// Where element matrices go: the pattern of a node graph with every node expanded to its
/// components, cut to the rows and columns of a selection of dofs. Rows sorted.
class MatrixPattern {
public:
  /// Throws Failure(limit) when the entries do not fit 32-bit indices. The graph must outlive this.
  MatrixPattern(const NodeGraph& graph, int components, const DofSelection& dofs);

  const SparseMatrix& zeros() const { return zeros_; }
  /// Moves the arrays of `zeros` into the last matrix that needs them.
  void hand_over(SparseMatrix& zeros) { zeros.swap(zeros_); }

  /// Of each pair of nodes of an element, its edge in the graph: edges[i * nodes + j].
  void locate(std::span<const std::int32_t> nodes, std::vector<int>& edges) const;
  /// element[(i * components + c) * width + j * components + d], width = nodes * components, is
  /// the coupling of dofs (nodes[i], c) and (nodes[j], d). It is added to the values of a matrix
  /// with this pattern.
  void add(std::span<const std::int32_t> nodes, std::span<const int> edges, const double* element,
           double* values) const;

private:
  void count_columns();
  void fill_columns();
  void fill_row(int node, int* columns) const;
  template <int Components>
  void add_fixed(std::span<const std::int32_t> nodes, std::span<const int> edges,
                 const double* element, double* values) const;
  void add_of(int components, std::span<const std::int32_t> nodes, std::span<const int> edges,
              const double* element, double* values) const;
  int entry(int node, int component) const {
    const int dof = node * components_ + component;
    return dofs_.entry_of.empty() ? dof : dofs_.entry_of[dof];
  }

  const NodeGraph* graph_;
  int components_;
  DofSelection dofs_;
  SparseMatrix zeros_;
  std::vector<char> whole_;     ///< has the node all its components among the rows' entries?
  std::vector<int> row_start_;  ///< by dof: where its row begins; -1: it has none
  std::vector<int> row_length_; ///< by node: of each of its rows
  /// By edge: where in a row the entries of its far node begin, those with a row and the others.
  std::vector<int> with_row_, without_row_;
};

} // namespace hvi::solver
