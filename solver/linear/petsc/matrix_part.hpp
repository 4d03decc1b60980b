// What a process reads of a matrix of all: its own rows, and numbers of the unknowns that their
// columns stand for, some of which other processes have. All calls are made by all processes
// together, but those for a row or a number.
#pragma once

#include "solver/linear/petsc/views.hpp"

#include <optional>
#include <vector>

namespace hvi::petsc_module {

/// A row of this process, in ascending columns of the whole.
class RowOf {
public:
  RowOf(Mat matrix, int row) : matrix_(matrix), row_(row) {
    check(MatGetRow(matrix_, row_, &size_, &column_, &value_));
  }
  ~RowOf() { static_cast<void>(MatRestoreRow(matrix_, row_, &size_, &column_, &value_)); }
  RowOf(const RowOf&) = delete;
  RowOf& operator=(const RowOf&) = delete;
  int size() const { return size_; }
  int column(int e) const { return column_[e]; }
  double value(int e) const { return value_[e]; }
  double entry(int column) const; ///< 0 where there is none

private:
  Mat matrix_;
  PetscInt row_, size_ = 0;
  const PetscInt* column_ = nullptr;
  const PetscScalar* value_ = nullptr;
};

/// A number of each row of the whole, as the columns of a matrix's rows here ask for it.
class NumbersOfColumns {
public:
  /// Both are kept by reference.
  NumbersOfColumns(const Distribution& distribution, Mat matrix);
  /// Those of this process's rows, which the others learn from it.
  void set(const std::vector<double>& mine);
  double operator[](int column) const;

private:
  const Distribution& distribution_;
  std::vector<double> mine_;
  std::vector<int> others_; ///< columns of other processes, ascending
  Owned<Vec> all_, here_;   ///< null: alone
  Owned<VecScatter> scatter_;
  std::vector<double> of_others_;
};

/// Entries next to their mirror images.
class MirrorImages {
public:
  MirrorImages(const Distribution& distribution, Mat matrix);
  /// f(j, a_ij, a_ji) of the entries of row i, which is here, in columns j that `chosen` takes.
  template <class Chosen, class F>
  void for_row(int i, const Chosen& chosen, const F& f) const {
    const RowOf row(matrix_, i);
    std::optional<RowOf> column;
    if (transposed_) column.emplace(transposed_.get(), i);
    for (int e = 0; e < row.size(); ++e) {
      const int j = row.column(e);
      if (chosen(j)) f(j, row.value(e), column ? column->entry(j) : RowOf(matrix_, j).entry(i));
    }
  }

private:
  Mat matrix_;
  Owned<Mat> transposed_; ///< null: alone
};

} // namespace hvi::petsc_module
