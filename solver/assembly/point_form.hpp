// Forms on cells whose coefficients change from step to step, by the points where these are known.
#pragma once

#include "solver/assembly/assembly.hpp"

namespace hvi::solver {

/// The values of D_index(phi_j) at points inside cells, or of their jumps at points of a pair:
/// points x n_dofs. Throws Failure(bad_value)
/// for an index that the space does not have.
SparseMatrix derivative_rows(const Space& space, const PointBlock& points, int index,
                             Origin origin);

///   K_ij = sum_p w_p sum_e C_e(x_p, ..) D_{trial_e}(phi_j)(x_p) D_{test_e}(phi_i)(x_p)
class PointForm {
public:
  /// Keeps references to space and term. The points come cell by cell.
  PointForm(const Space& space, PointBlock points, const FormTerm& term);
  /// into = K. `into` has the pattern of assemble_form with these dofs; `more`: the values at the
  /// points of slots besides x and the indicators of parts. Throws as `evaluate` does.
  void assemble(const DofSelection& dofs, const Pointwise::Columns& more, SparseMatrix& into,
                const double* t = nullptr);
  /// Throws Failure(bad_value) naming the point, and the time where it is given, where a
  /// coefficient is not finite.
  void evaluate(const Pointwise::Columns& more, const double* t);
  std::size_t points() const { return points_.size(); }

private:
  struct Entry {
    Derivative test, trial;
  };
  void add_point(std::size_t p, DenseMatrix& of_cell);

  const Space* space_;
  const FormTerm* term_;
  PointBlock points_;
  std::vector<Entry> entries_;
  Pointwise coefficients_;
  std::vector<double> values_; ///< of the coefficients
};

} // namespace hvi::solver
