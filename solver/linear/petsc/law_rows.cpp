// See law_rows.hpp.
#include "solver/linear/petsc/law_rows.hpp"

namespace hvi::petsc_module {

void LawRows::set(const Distribution& distribution, Vec like, const HviPetscMatrix& whole) {
  h_ = distribution.deal(whole, mine_);
  halo_.want(distribution, like, mine_.column);
  rows_.clear();
  for (int i = 0; i < h_.rows; ++i)
    if (h_.start[i] < h_.start[i + 1]) rows_.push_back(i);
  any_ = distribution.any(!rows_.empty());
}

PetscErrorCode LawRows::add_product(Vec x, Vec y) const {
  if (!any_) return 0;
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(halo_.read(x, &from));
  PetscCall(VecGetArray(y, &to));
  for (const int i : rows_)
    for (int e = h_.start[i]; e < h_.start[i + 1]; ++e) to[i] += h_.value[e] * from[h_.column[e]];
  PetscCall(VecRestoreArray(y, &to));
  PetscCall(halo_.done(x, &from));
  return 0;
}

} // namespace hvi::petsc_module
