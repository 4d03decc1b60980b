// The layers of cells at the contact, solved exactly.
//
// H is stiff where contact is closed or sticks, and no cycle of K knows it. With X the unknowns
// that laws touch and their neighbours in K, the preconditioner M of K becomes, for A = K + H,
//
//   z = S r,   z += M (r - A z),   z += S (r - A z),   S = A_XX^-1
//
// (multiplicative Schwarz with X first and last, so that it is symmetric where A is: B. Smith,
// P. Bjorstad, W. Gropp, Domain decomposition, Cambridge University Press, 1996).
//
// With several processes X is divided into parts, one for each, so that what H couples is in one
// part, and a process solves with its own. Be D the entries within the parts and N those between
// them, A_XX = D + N. With L the diagonal of the sums of the sizes of N's rows, S = (D + L / 2)^-1,
// so that 2 S^-1 - A_XX = D + (L - N) >= D: the preconditioner is positive definite where A is,
// with any number of parts (such sums: A. Baker, R. Falgout, T. Kolev, U. Yang, Multigrid smoothers
// for ultraparallel computing, SIAM J. Sci. Comput. 33 (2011) 2864-2887).
#pragma once

#include "solver/linear/petsc/few_rows.hpp"

#include <optional>
#include <vector>

namespace hvi::petsc_module {

class Layers {
public:
  /// X: the rows where `h` has entries, and their neighbours in `k`. Both are whole, in PETSc's
  /// numbering, and of the first process; `k` is kept by reference.
  Layers(const Distribution& distribution, Vec like, const WholeMatrix& k, const Rows& h);
  /// Are these the layers of an h of this pattern?
  bool fit(const Rows& h) const { return h.start == start_ && h.column == column_; }
  /// K has other entries.
  void matrix_changed(Vec like);
  /// Factors A_XX, with `shift` of the size of K's diagonal added to its own. False: it has no
  /// factor.
  bool factor(const Rows& h, bool symmetric, double shift);
  double bytes() const; ///< of this process

  PetscErrorCode add_solved(Vec r, Vec z) const; ///< z += S r
  /// r -= K z in X and next to it: everywhere for a z that is 0 outside of X.
  PetscErrorCode subtract_product(Vec z, Vec r) const { return near_.add_product(-1.0, z, r); }

private:
  std::vector<int> find(const Rows& h);
  std::vector<int> parts_of(const Rows& h) const;
  Rows assembled(const Rows& h, double shift) const;
  void take(Rows whole);
  bool factored();

  const Distribution& distribution_;
  const WholeMatrix& k_;
  std::vector<int> start_, column_;   ///< pattern of h
  std::vector<int> inside_;           ///< X, one part after the other
  std::vector<int> position_;         ///< in X, or -1
  std::vector<int> part_;             ///< of X: the process that solves with it
  std::vector<int> beside_;           ///< X and its neighbours
  std::optional<Distribution> parts_; ///< of X
  Rows near_rows_;                    ///< K's rows of X and its neighbours, of the first process
  FewRows near_;
  Rows local_; ///< what is factored here
  Owned<Mat> matrix_, factor_;
  Owned<Vec> right_, left_; ///< of this part
  Owned<VecScatter> scatter_;
  bool symmetric_ = true;
};

} // namespace hvi::petsc_module
