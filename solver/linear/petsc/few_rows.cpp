// See few_rows.hpp.
#include "solver/linear/petsc/few_rows.hpp"

namespace hvi::petsc_module {

void FewRows::set(const Distribution& distribution, Vec like, const HviPetscMatrix& whole) {
  here_ = distribution.deal(whole, mine_);
  halo_.want(distribution, like, mine_.column);
  rows_.clear();
  for (int i = 0; i < here_.rows; ++i)
    if (here_.start[i] < here_.start[i + 1]) rows_.push_back(i);
  any_ = distribution.any(!rows_.empty());
}

PetscErrorCode FewRows::add_product(double factor, Vec x, Vec y) const {
  if (!any_) return 0;
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(halo_.read(x, &from));
  PetscCall(VecGetArray(y, &to));
  for (const int i : rows_) {
    double sum = 0.0;
    for (int e = here_.start[i]; e < here_.start[i + 1]; ++e)
      sum += here_.value[e] * from[here_.column[e]];
    to[i] += factor * sum;
  }
  PetscCall(VecRestoreArray(y, &to));
  PetscCall(halo_.done(x, &from));
  return 0;
}

double FewRows::bytes() const {
  return static_cast<double>(mine_.column.size()) * (sizeof(double) + sizeof(int));
}

} // namespace hvi::petsc_module
