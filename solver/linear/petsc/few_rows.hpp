// A matrix of which few rows have entries, by each process the rows that it has.
#pragma once

#include "solver/linear/petsc/views.hpp"

#include <vector>

namespace hvi::petsc_module {

class FewRows {
public:
  /// `whole`: of the first process, which keeps it as long as it is used.
  void set(const Distribution& distribution, Vec like, const HviPetscMatrix& whole);
  PetscErrorCode add_product(double factor, Vec x, Vec y) const; ///< y += factor A x
  double bytes() const;                                          ///< copied, of this process

private:
  Rows mine_;
  HviPetscMatrix here_{}; ///< columns: places in what the halo gives
  std::vector<int> rows_; ///< with entries
  bool any_ = false;      ///< has any process one?
  Halo halo_;
};

} // namespace hvi::petsc_module
