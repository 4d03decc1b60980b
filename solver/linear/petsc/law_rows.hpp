// H, by each process the rows that it has.
#pragma once

#include "solver/linear/petsc/views.hpp"

#include <vector>

namespace hvi::petsc_module {

class LawRows {
public:
  /// `whole`: of the first process, which keeps it as long as it is used.
  void set(const Distribution& distribution, Vec like, const HviPetscMatrix& whole);
  PetscErrorCode add_product(Vec x, Vec y) const; ///< y += H x

private:
  Rows mine_;
  HviPetscMatrix h_{};    ///< columns: places in what the halo gives
  std::vector<int> rows_; ///< with entries
  bool any_ = false;      ///< has any process one?
  Halo halo_;
};

} // namespace hvi::petsc_module
