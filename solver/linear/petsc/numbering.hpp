// The unknowns as PETSc numbers them: all components of every node, one after the other. A
// component that is no unknown has a row of its own with its diagonal entry only, and is 0. Several
// processes have a block of nodes each, one after the other.
#pragma once

#include "solver/linear/petsc/partition.hpp"

#include <functional>
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

/// A matrix as the first process sees it, in PETSc's numbering, row by row: where it is numbered
/// otherwise, no second copy of it is kept. Where its rows are dealt out, the first process knows
/// those that it has asked for.
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

  /// Dealt out: `fetch`, called by all processes together, gives the first one the rows that it
  /// names. `rows`: of the first process all, of the others 0.
  using Fetch = std::function<Rows(const std::vector<int>& named)>;
  WholeMatrix(int rows, Fetch fetch)
      : a_{rows, nullptr, nullptr, nullptr}, fetch_(std::move(fetch)),
        known_(static_cast<std::size_t>(rows), -1) {}

  int rows() const { return numbering_ == nullptr ? a_.rows : numbering_->size(); }
  bool is_dealt() const { return fetch_ != nullptr; }
  /// The matrix itself; null: it is numbered otherwise, or dealt out.
  const HviPetscMatrix* as_it_is() const {
    return numbering_ == nullptr && !is_dealt() ? &a_ : nullptr;
  }
  /// By all processes together: `row` and `entry` may be asked for these rows from now on.
  void need(const std::vector<int>& named) const;
  /// The entries have changed.
  void changed() const;
  /// Until the next call with this room, or of `need`.
  Row row(int i, Room& room) const;
  double entry(int i, int j) const;    ///< 0 where there is none
  Rows part(int first, int end) const; ///< these rows

private:
  int entries_of(int i) const;

  HviPetscMatrix a_;
  const Numbering* numbering_ = nullptr;
  double diagonal_ = 0.0;
  Fetch fetch_;
  // What was fetched: rows one after the other, and where each row is among them.
  mutable Rows fetched_;
  mutable std::vector<int> known_;
};

} // namespace hvi::petsc_module
