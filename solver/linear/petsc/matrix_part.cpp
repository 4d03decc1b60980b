// See matrix_part.hpp.
#include "solver/linear/petsc/matrix_part.hpp"

#include <algorithm>

namespace hvi::petsc_module {

double RowOf::entry(int column) const {
  const PetscInt* const end = column_ + size_;
  const PetscInt* const at = std::lower_bound(column_, end, column);
  return at != end && *at == column ? value_[at - column_] : 0.0;
}

NumbersOfColumns::NumbersOfColumns(const Distribution& distribution, Mat matrix)
    : distribution_(distribution) {
  if (distribution.alone()) return;
  Mat own = nullptr, rest = nullptr;
  const PetscInt* columns = nullptr;
  PetscInt rows = 0, count = 0;
  check(MatMPIAIJGetSeqAIJ(matrix, &own, &rest, &columns));
  check(MatGetSize(rest, &rows, &count));
  others_.assign(columns, columns + count);
  check(MatCreateVecs(matrix, all_.put(), nullptr));
  check(VecCreateSeq(PETSC_COMM_SELF, count, here_.put()));
  connect(all_.get(), others_, here_.get(), scatter_);
}

void NumbersOfColumns::set(const std::vector<double>& mine) {
  mine_ = mine;
  if (!all_) return;
  double* to = nullptr;
  check(VecGetArrayWrite(all_.get(), &to));
  std::copy(mine.begin(), mine.end(), to);
  check(VecRestoreArrayWrite(all_.get(), &to));
  check(VecScatterBegin(scatter_.get(), all_.get(), here_.get(), INSERT_VALUES, SCATTER_FORWARD));
  check(VecScatterEnd(scatter_.get(), all_.get(), here_.get(), INSERT_VALUES, SCATTER_FORWARD));
  const double* from = nullptr;
  check(VecGetArrayRead(here_.get(), &from));
  of_others_.assign(from, from + others_.size());
  check(VecRestoreArrayRead(here_.get(), &from));
}

double NumbersOfColumns::operator[](int column) const {
  const int own = column - distribution_.first_row();
  if (own >= 0 && own < distribution_.rows()) return mine_[own];
  return of_others_[std::lower_bound(others_.begin(), others_.end(), column) - others_.begin()];
}

MirrorImages::MirrorImages(const Distribution& distribution, Mat matrix) : matrix_(matrix) {
  if (!distribution.alone()) check(MatTranspose(matrix, MAT_INITIAL_MATRIX, transposed_.put()));
}

} // namespace hvi::petsc_module
