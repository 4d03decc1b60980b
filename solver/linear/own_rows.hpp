// The rows that one of several processes has of some matrices with one pattern: the base matrices
// of a problem, and sums of them.
#pragma once

#include "solver/linear/sparse.hpp"

#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace hvi::solver {

/// Where PETSc has a process's unknowns: rows of all components of its nodes, one after the other.
struct PlacedRows {
  int first = 0, count = 0;         ///< rows of this process
  std::vector<std::int32_t> column; ///< PETSc's, of each column here; -1: an imposed value
  /// Of several unknowns, of which each column is; empty: there is one.
  std::vector<std::uint8_t> of_unknown{};
};

/// Rows of a matrix in the numbering of all; arrays of its owner.
struct RowArrays {
  int rows = 0;
  const int* start = nullptr;
  const int* column = nullptr;
  const double* value = nullptr;
};

class OwnRows {
public:
  /// Columns: the unknowns of the rows, in their order, then what only others have rows of. Base b
  /// is matrix b.
  OwnRows(std::vector<SparseMatrix> bases, PlacedRows placed);

  /// Base b gets other values; its pattern is that which it had, or less.
  void replace(int b, const SparseMatrix& base);

  int rows() const { return static_cast<int>(start_.size()) - 1; }
  int columns() const { return static_cast<int>(placed_.column.size()); }

  /// Of each row i of matrix a  (A x)_i,  and behind them  |A_ii| max |x_j| over its columns of the
  /// same unknown.
  void products(int a, std::span<const double> x, std::span<double> out) const;
  /// (A x)_i as the sum of two numbers, one block behind the other, and behind them (|A| |x|)_i.
  void precisely(int a, std::span<const double> x, std::span<double> out) const;
  /// (|A| |x|)_i
  void magnitudes(int a, std::span<const double> x, std::span<double> out) const;
  /// A_ii
  void diagonal(int a, std::span<double> out) const;
  /// Of each column j what these rows add to  (A^T x)_j,  and behind them to  (|A|^T |x|)_j.
  void transposed(int a, std::span<const double> x, std::span<double> out) const;
  /// The largest |a_ij - a_ji| of two of these rows' unknowns, the largest |a_ij|, and  i, j, a_ij
  /// of each entry whose mirror image another process has.
  std::vector<double> asymmetry(int a) const;
  /// Matrix a becomes sum_b gamma_b T_b.
  void combine(int a, std::span<const double> gamma);
  /// A_ii grows by more_i.
  void stiffen(int a, std::span<const double> more);
  /// Matrix a as PETSc is to have it: rows that are no unknown's have `alone` on their diagonal.
  /// They are there until `leave`.
  void place(int a, double alone);
  void leave(int a) { placed_arrays_.erase(a); }
  RowArrays placed(int a) const;
  void forget(int a);
  /// f(i, j, a_ij) of every entry.
  template <class F>
  void for_entries(int a, const F& f) const;
  double bytes() const;

private:
  struct Placed {
    std::vector<int> start, column;
    std::vector<double> value;
  };
  const std::vector<double>& values(int a) const { return values_.at(a); }
  void whole_of_each(int a, std::span<const double> x, std::span<double> whole) const;

  std::vector<double> values_of(const SparseMatrix& matrix) const;

  std::vector<int> start_, column_; ///< of all matrices
  std::vector<int> own_;            ///< by row where its diagonal is
  int bases_;
  std::map<int, std::vector<double>> values_; ///< by matrix, in the order of the columns
  std::map<int, Placed> placed_arrays_;
  PlacedRows placed_;
};

template <class F>
void OwnRows::for_entries(int a, const F& f) const {
  const double* const value = values(a).data();
  for (int i = 0; i < rows(); ++i)
    for (int e = start_[i]; e < start_[i + 1]; ++e) f(i, column_[e], value[e]);
}

} // namespace hvi::solver
