// The two triangular solves with the interior columns of a supernodal Cholesky factor. Their time
// is that of reading memory; this code reads every entry of L once and nothing else twice.
#pragma once

#include "solver/linear/sparse.hpp"

#include <cholmod.h>

#include <span>
#include <vector>

namespace hvi::solver {

/// The columns [first, first + columns) of L: a dense panel of `rows` rows, by columns with leading
/// dimension `stride`. Its first `columns` rows are a lower triangle, row i of the rest is `below`.
struct Panel {
  int first, columns, rows, stride;
  std::size_t values; ///< offset of its top left entry
  std::size_t below;  ///< offset of its row indices (rows - columns of them)
};

/// The structure of the interior part of L; the values stay with whoever owns the factor.
class Supernodes {
public:
  Supernodes() = default;
  /// The structure of the first `interior` columns. A supernode that holds both interior and
  /// contact columns is cut: its interior columns see the contact ones as rows below.
  Supernodes(const cholmod_factor& l, int interior);

  /// Forward solve: y_I := L_II^-1 y_I, then y_c := y_c - L_cI y_I. `inverse_diagonal` has an entry
  /// per interior column.
  void forward(const double* values, const double* inverse_diagonal, double* y);
  /// x_I := L_II^-T (y_I - L_cI^T x_c), where x_c is given in x; y is not changed.
  void backward(const double* values, const double* inverse_diagonal, const double* y, double* x);

  /// Right-hand sides that a triangular solve takes at once: one pack of the widest registers.
  static constexpr int lanes = 8;
  /// The same for `groups` times `lanes` right-hand sides in one reading of L, in place: y_I stands
  /// in x_I. y and x have all of them for a column of L next to each other.
  void forward_all(const double* values, const double* inverse_diagonal, int groups, double* y);
  void backward_all(const double* values, const double* inverse_diagonal, int groups, double* x);

  std::span<const Panel> panels() const { return panels_; }
  std::span<const int> below() const { return below_; } ///< row indices of all panels
  /// Entries of L that a triangular solve reads.
  double nonzeros() const;

private:
  std::vector<double> work_for(int row) const; ///< rows of the tallest panel, `row` numbers each

  std::vector<Panel> panels_;
  std::vector<int> below_;
  std::vector<double> work_; ///< as long as the tallest panel
};

} // namespace hvi::solver
