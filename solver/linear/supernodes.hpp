// The two triangular solves with the interior columns of a supernodal Cholesky factor. Their time
// is that of reading memory; this code reads every entry of L once and nothing else twice.
#pragma once

#include "solver/linear/elimination_order.hpp"

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
  /// per interior column. `values` are doubles or floats.
  template <class Entry>
  void forward(const Entry* values, const double* inverse_diagonal, RightHandSides y);
  /// x_I := L_II^-T (y_I - L_cI^T x_c), with y_I where x_I is to stand, and x_c given.
  template <class Entry>
  void backward(const Entry* values, const double* inverse_diagonal, RightHandSides x);

  std::span<const Panel> panels() const { return panels_; }
  std::span<const int> below() const { return below_; } ///< row indices of all panels
  /// Entries of L that a triangular solve reads.
  double nonzeros() const;

private:
  double* work_for(int stride);

  std::vector<Panel> panels_;
  std::vector<int> below_;
  int tallest_ = 0;          ///< rows of a panel
  std::vector<double> work_; ///< room within a solve: the rows of a panel
};

/// L of K = L L^T on the columns of the interior: for those who copy it.
struct LowerFactor {
  Supernodes structure;
  const double* values = nullptr; ///< null: there is none yet, or it has singles
  std::vector<double> inverse_diagonal;
};

} // namespace hvi::solver
