// The motions of bodies that laws alone hold, solved exactly.
//
// K all but takes the columns of N to 0, and what A = K + H does to them depends on where the laws
// are: no multigrid of K knows it. With Q = N (N^T A N)^-1 N^T a preconditioner M becomes
//
//   Q + (1 - Q A) M (1 - A Q)
//
// (the balancing preconditioner: J. Mandel, Balancing domain decomposition, Commun. Numer. Methods
// Eng. 9 (1993) 233-241), which is symmetric where A is. Where A is not, the first projection is
// left out.
#pragma once

#include "solver/linear/petsc/distribution.hpp"

#include <vector>

namespace hvi::petsc_module {

class FreeMotions {
public:
  /// `motions`: `count` columns, each process's rows of them. `distribution` is kept by reference.
  FreeMotions(const Distribution& distribution, std::vector<double> motions, int count);
  int count() const { return count_; }
  /// N^T A N of this A. False: it is singular, to rounding.
  bool factor(Mat a);
  /// out = r - A Q r, and what `add` takes as N^T A N's answer.
  PetscErrorCode remove(Vec r, Vec out);
  /// z += Q r; `project`: z -= Q A z before.
  PetscErrorCode add(bool project, Vec z);
  double bytes() const; ///< of this process

private:
  bool any_pivot_is_rounding(const std::vector<double>& given) const;
  void solve(std::vector<double>& right) const;
  std::vector<double> products(const std::vector<double>& columns, const double* x) const;
  void add_columns(const std::vector<double>& columns, const std::vector<double>& by, double factor,
                   double* x) const;

  const Distribution& distribution_;
  std::size_t size_;
  int count_;
  std::vector<double> motions_, moved_; ///< N, A N
  std::vector<double> small_;           ///< N^T A N, factored
  std::vector<PetscBLASInt> pivots_;
  std::vector<double> amplitudes_;
};

} // namespace hvi::petsc_module
