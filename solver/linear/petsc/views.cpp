// See views.hpp.
#include "solver/linear/petsc/views.hpp"

#include <algorithm>
#include <numeric>

namespace hvi::petsc_module {
namespace {

std::vector<int> all_of(const Distribution& distribution) {
  std::vector<int> out(
      static_cast<std::size_t>(distribution.is_first() ? distribution.all_rows() : 0));
  std::iota(out.begin(), out.end(), 0);
  return out;
}

} // namespace

void connect(Vec like, const std::vector<int>& from, Vec here, Owned<VecScatter>& scatter) {
  Owned<IS> there, to;
  const PetscInt n = static_cast<PetscInt>(from.size());
  check(ISCreateGeneral(PETSC_COMM_SELF, n, from.data(), PETSC_USE_POINTER, there.put()));
  check(ISCreateStride(PETSC_COMM_SELF, n, 0, 1, to.put()));
  check(VecScatterCreate(like, there.get(), here, to.get(), scatter.put()));
}

View::View(const Distribution& distribution, Vec like) {
  if (distribution.alone()) return;
  const std::vector<int> all = all_of(distribution);
  check(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(all.size()), whole_.put()));
  connect(like, all, whole_.get(), scatter_);
}

PetscErrorCode View::read(Vec x, const double** values) const {
  if (!whole_) return VecGetArrayRead(x, values);
  PetscCall(VecScatterBegin(scatter_.get(), x, whole_.get(), INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(scatter_.get(), x, whole_.get(), INSERT_VALUES, SCATTER_FORWARD));
  return VecGetArrayRead(whole_.get(), values);
}

PetscErrorCode View::done(Vec x, const double** values) const {
  return VecRestoreArrayRead(whole_ ? whole_.get() : x, values);
}

PetscErrorCode View::write(Vec x, double** values) const {
  return VecGetArray(whole_ ? whole_.get() : x, values);
}

PetscErrorCode View::put(Vec x, double** values) const {
  if (!whole_) return VecRestoreArray(x, values);
  PetscCall(VecRestoreArray(whole_.get(), values));
  PetscCall(VecScatterBegin(scatter_.get(), whole_.get(), x, INSERT_VALUES, SCATTER_REVERSE));
  return VecScatterEnd(scatter_.get(), whole_.get(), x, INSERT_VALUES, SCATTER_REVERSE);
}

void Halo::want(const Distribution& distribution, Vec like, std::vector<int>& columns) {
  if (distribution.alone()) return;
  std::vector<int> wanted = columns;
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  if (distribution.any(!here_ || wanted != wanted_)) {
    wanted_ = std::move(wanted);
    check(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(wanted_.size()), here_.put()));
    connect(like, wanted_, here_.get(), scatter_);
  }
  for (int& column : columns)
    column = static_cast<int>(std::lower_bound(wanted_.begin(), wanted_.end(), column) -
                              wanted_.begin());
}

PetscErrorCode Halo::read(Vec x, const double** values) const {
  if (!here_) return VecGetArrayRead(x, values);
  PetscCall(VecScatterBegin(scatter_.get(), x, here_.get(), INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(scatter_.get(), x, here_.get(), INSERT_VALUES, SCATTER_FORWARD));
  return VecGetArrayRead(here_.get(), values);
}

PetscErrorCode Halo::done(Vec x, const double** values) const {
  return VecRestoreArrayRead(here_ ? here_.get() : x, values);
}

} // namespace hvi::petsc_module
