// The unknowns as PETSc numbers them: all components of every node, one after the other. A
// component that is no unknown has a row of its own with its diagonal entry only, and is 0. Several
// processes have a block of nodes each, one after the other.
#pragma once

#include "solver/linear/petsc/partition.hpp"

#include <utility>
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
  bool is_unknown(int row) const { return unknown_of(row) >= 0; }
  int operator[](int unknown) const { return same_ ? unknown : place_[unknown]; }

  /// -1 where a row is no unknown's.
  int unknown_of(int row) const { return same_ ? row : unknown_[row]; }
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

/// A matrix of the first process in PETSc's numbering, row by row: where it is numbered otherwise,
/// no second copy of it is kept.
class WholeMatrix {
public:
  /// Entries in ascending columns.
  struct Row {
    const int* column;
    const double* value;
    int size;
  };
  /// Of a row that is numbered anew.
  struct Room {
    std::vector<std::pair<int, double>> entries;
    std::vector<int> column;
    std::vector<double> value;
  };

  /// As it is numbered. Its arrays are kept by reference.
  explicit WholeMatrix(const HviPetscMatrix& a) : a_(a) {}
  /// Of unknowns. Both are kept by reference. `diagonal`: of rows that are no unknown's; 0: without
  /// an entry.
  WholeMatrix(const HviPetscMatrix& a, const Numbering& numbering, double diagonal)
      : a_(a), numbering_(numbering.same() ? nullptr : &numbering), diagonal_(diagonal) {}

  int rows() const { return numbering_ == nullptr ? a_.rows : numbering_->size(); }
  /// The matrix itself; null: it is numbered otherwise.
  const HviPetscMatrix* as_it_is() const { return numbering_ == nullptr ? &a_ : nullptr; }
  /// Until the next call with this room.
  Row row(int i, Room& room) const;
  double entry(int i, int j) const;    ///< 0 where there is none
  Rows part(int first, int end) const; ///< these rows

private:
  int entries_of(int i) const;

  HviPetscMatrix a_;
  const Numbering* numbering_ = nullptr;
  double diagonal_ = 0.0;
};

} // namespace hvi::petsc_module
