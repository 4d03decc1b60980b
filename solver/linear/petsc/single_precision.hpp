// A matrix whose entries are kept in single precision, for a cycle of multigrid: a preconditioner
// needs few digits, and a cycle takes the time of reading its matrices. Products are summed in
// double precision.
#pragma once

#include "solver/linear/petsc/session.hpp"

#include <memory>
#include <vector>

namespace hvi::petsc_module {

/// A matrix of one process, by dense blocks of one size.
class SingleBlocks {
public:
  /// Blocks that no product is compiled for are taken entry by entry.
  SingleBlocks(Mat sequential, int block_rows, int block_columns);
  void add_product(const double* x, double* y) const;    ///< y += A x
  void add_transposed(const double* x, double* y) const; ///< y += A^T x
  /// Calls `take` with each column and entry of a row that is not 0.
  template <class Take>
  void read_row(int i, const Take& take) const;
  double bytes() const;

private:
  struct Block;
  void read(Mat sequential, int rows, int columns);

  int block_rows_ = 1, block_columns_ = 1;
  std::vector<int> start_, column_; ///< of block rows, of blocks
  std::vector<float> value_;        ///< of a block column by column; times scale_
  double scale_ = 1.0;              ///< so that no entry is beyond the range of single precision
};

/// The rows that this process has of a matrix of all processes, and a matrix of PETSc's that
/// multiplies by them.
class SingleMatrix {
public:
  SingleMatrix(Mat a, int block_rows, int block_columns);
  SingleMatrix(const SingleMatrix&) = delete;
  SingleMatrix& operator=(const SingleMatrix&) = delete;
  Mat shell() const { return shell_.get(); }
  /// From now on of a square matrix the sum of it and `few`, which is kept by reference and has
  /// entries in these rows of this process only; null: the matrix alone. Of `few` the diagonal that
  /// is asked for has the sums of the sizes of rows, so that diagonal - few >= 0 and smoothers made
  /// for the matrix serve (such sums: A. Baker, R. Falgout, T. Kolev, U. Yang, Multigrid smoothers
  /// for ultraparallel computing, SIAM J. Sci. Comput. 33 (2011) 2864-2887).
  void add(Mat few, const std::vector<int>& rows);
  /// The same matrix with these rows of this process alone, ascending.
  void only(const std::vector<int>& rows, Owned<Mat>& out) const;
  double bytes() const { return own_->bytes() + (others_ ? others_->bytes() : 0.0); }

private:
  template <bool transpose>
  static PetscErrorCode product(Mat shell, Vec x, Vec before, Vec y);
  template <bool transpose>
  static PetscErrorCode product_alone(Mat shell, Vec x, Vec y);
  static PetscErrorCode diagonal(Mat shell, Vec d);
  PetscErrorCode add_product(Vec x, Vec y) const;
  PetscErrorCode add_transposed(Vec x, Vec y) const;
  void make_shell(Mat a);

  std::unique_ptr<SingleBlocks> own_, others_; ///< whose columns this process has, and has not
  std::vector<PetscInt> columns_;              ///< of `others_`, among those of all processes
  Owned<VecScatter> halo_;
  Owned<Vec> ghosts_;
  Mat few_ = nullptr;
  Owned<Vec> own_diagonal_, diagonal_; ///< of a square matrix: of itself, of the sum
  Owned<Mat> shell_;
};

} // namespace hvi::petsc_module
