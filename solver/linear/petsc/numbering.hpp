// The unknowns as PETSc numbers them: all components of every node, one after the other. A
// component that is no unknown has a row of its own with its diagonal entry only, and is 0. Several
// processes have a block of nodes each, one after the other.
#pragma once

#include "solver/linear/petsc/partition.hpp"

#include <vector>

namespace hvi::petsc_module {

/// Arrays of a matrix that is held here.
struct Rows {
  std::vector<int> start{0}, column;
  std::vector<double> value;
  int size() const { return static_cast<int>(start.size()) - 1; }
  HviPetscMatrix view() const { return {size(), start.data(), column.data(), value.data()}; }
};

/// 0 where there is none.
double entry(const HviPetscMatrix& a, int row, int column);

class Numbering {
public:
  /// `n` unknowns, whose nodes are where the partition has them.
  Numbering(const HviPetscUnknowns& unknowns, int n, const Partition& partition);
  int size() const { return nodes_ * components_; }
  int components() const { return components_; }
  /// Are the unknowns numbered so already?
  bool same() const { return same_; }
  bool is_unknown(int row) const { return same_ || unknown_[row] >= 0; }
  int operator[](int unknown) const { return same_ ? unknown : place_[unknown]; }

  /// The matrix in this numbering. `diagonal`: of rows that are no unknown's; 0: without an entry.
  Rows rows_of(const HviPetscMatrix& a, double diagonal) const;
  /// Its entries once more, where the pattern is the same.
  void refresh(const HviPetscMatrix& a, double diagonal, Rows& rows) const;
  void spread(const double* x, double* out) const; ///< 0 where there is no unknown
  void collect(const double* x, double* out) const;
  /// Rows of each process.
  const std::vector<int>& counts() const { return counts_; }

private:
  int nodes_, components_;
  bool same_;
  std::vector<int> counts_;
  std::vector<int> place_, unknown_; ///< of each unknown, and back; -1: none
};

} // namespace hvi::petsc_module
