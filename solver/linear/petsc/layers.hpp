// The layers of cells at the contact, solved exactly.
//
// H is stiff where contact is closed or sticks, and no cycle of K knows it. With X the unknowns
// that laws touch and their neighbours in K, the preconditioner M of K becomes, for A = K + H,
//
//   z = A_XX^-1 r,   z += M (r - A z),   z += A_XX^-1 (r - A z)
//
// (multiplicative Schwarz with X first and last, so that it is symmetric where A is: B. Smith,
// P. Bjorstad, W. Gropp, Domain decomposition, Cambridge University Press, 1996).
// With several processes the first one does this, and the others have no layers.
#pragma once

#include "solver/linear/petsc/numbering.hpp"
#include "solver/linear/petsc/session.hpp"

#include <vector>

namespace hvi::petsc_module {

class Layers {
public:
  /// The arrays of `k` are kept by reference; X: the rows where `h` has entries, and their
  /// neighbours. `h` and `k` in PETSc's numbering.
  Layers(const HviPetscMatrix& k, const Rows& h);
  /// Are these the layers of an h of this pattern?
  bool fit(const Rows& h) const { return h.start == start_ && h.column == column_; }
  /// Factors A_XX, with `shift` of the size of K's diagonal added to its own. False: it has no
  /// factor.
  bool factor(const Rows& h, bool symmetric, double shift);
  int size() const { return static_cast<int>(inside_.size()); }
  /// X and its neighbours.
  const std::vector<int>& touched() const { return touched_; }
  double bytes() const;

  /// z += A_XX^-1 r on X.
  PetscErrorCode solve(const double* r, double* z) const;
  /// r -= A z on the rows that X touches, for a z that is 0 outside of X.
  void subtract_product(const Rows& h, const double* z, double* r) const;
  /// (r - A z) on X only, for any z; the other entries of `out` are left.
  void residual_inside(const Rows& h, const double* r, const double* z, double* out) const;

private:
  void assemble(const Rows& h, double shift);
  double product(const Rows& h, int row, const double* z) const;

  HviPetscMatrix k_;
  std::vector<int> start_, column_; ///< pattern of h
  std::vector<int> inside_;         ///< X, increasing
  std::vector<int> position_;       ///< in X, or -1
  std::vector<int> touched_;        ///< X and its neighbours
  Rows local_;                      ///< A_XX
  Owned<Mat> matrix_, factor_;
  Owned<Vec> right_, left_;
  bool symmetric_ = true;
};

} // namespace hvi::petsc_module
