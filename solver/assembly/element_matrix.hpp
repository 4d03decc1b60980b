// Element matrices of bilinear forms.
//
// At a quadrature point the entries between component c of the test function and component d of the
// trial function form a small matrix T over the rows of a ShapeTable S (value, d/dx_0, ...); the
// element matrix of that pair is  sum_q w_q S^T T S. In mixed spaces S has the rows of P1 on the
// side of an unknown in P1.
#pragma once

#include "solver/fem/geometry.hpp"
#include "solver/plan/problem.hpp"

namespace hvi::solver {

/// The entries of a form, sorted by pairs of components.
struct FormEntries {
  /// Where one entry stands in the matrix T of its pair.
  struct Place {
    int block, row, column;
  };
  struct Block {
    int test_component, trial_component;
    int test_rows, trial_rows; ///< where its rows begin: 0, or linear_rows
    std::array<std::array<double, 4>, 4> t{};
  };
  std::vector<Place> places;
  std::vector<Block> blocks;
  std::vector<Expr> coefficients;
  bool constant = true, gradients = false, values = false;
  bool mixed = false; ///< rows of P1 beside the space's own
  int degree = 0;     ///< for the rule `exact`

  /// Sets T of every block from the coefficients at one point, `stride` apart.
  void set(const double* at_point, std::size_t stride);
};
/// Entries with coefficient 0 are left out. Throws Failure(bad_value) for derivatives the space
/// does not have and constants that are not finite.
FormEntries sort_entries(const Space& space, const FormTerm& term);

/// An element matrix under construction. `local` lists the shape functions of the cell that take
/// part, `nodes` their nodes; entry ((i, c), (j, d)) stands at
/// (i components + c) width + j components + d, width = nodes * components.
struct ElementMatrix {
  std::vector<std::int32_t> nodes;
  std::vector<int> local;
  int components = 1;
  std::vector<double> data;
  void clear();
};

/// data += weight S^T T S for all blocks.
using ElementKernel = void (*)(ElementMatrix&, const FormEntries&, const ShapeTable&,
                               double weight);
/// A kernel with the loop bounds of these entries on whole cells of this space compiled in (they
/// unroll and vectorise), or the general one.
ElementKernel whole_cell_kernel(const Space& space, const FormEntries& entries);
/// For any choice of shape functions.
void general_kernel(ElementMatrix& element, const FormEntries& entries, const ShapeTable& shapes,
                    double weight);

} // namespace hvi::solver
