// See law_levels.hpp.
#include "solver/linear/petsc/law_levels.hpp"

#include <algorithm>

namespace hvi::petsc_module {
namespace {

/// Of this process, from 0 on.
std::vector<int> rows_with_entries(Mat a) {
  PetscInt first = 0, end = 0;
  check(MatGetOwnershipRange(a, &first, &end));
  std::vector<int> out;
  for (PetscInt i = first; i < end; ++i) {
    PetscInt count = 0;
    check(MatGetRow(a, i, &count, nullptr, nullptr));
    if (count > 0) out.push_back(i - first);
    check(MatRestoreRow(a, i, &count, nullptr, nullptr));
  }
  return out;
}

} // namespace

void LawLevels::set(const Distribution& distribution, const HviPetscMatrix& h) {
  const int entries = h.start[h.rows];
  any_ = distribution.any(entries > 0);
  const bool same = own_.size() == h.rows &&
                    std::equal(h.start, h.start + h.rows + 1, own_.start.begin()) &&
                    std::equal(h.column, h.column + entries, own_.column.begin());
  if (finest_ && !distribution.any(!same)) {
    std::copy_n(h.value, entries, own_.value.begin());
    distribution.refresh(own_.view(), finest_.get());
    return;
  }
  forget_levels();
  finest_.reset();
  own_.start.assign(h.start, h.start + h.rows + 1);
  own_.column.assign(h.column, h.column + entries);
  own_.value.assign(h.value, h.value + entries);
  distribution.make(own_.view(), finest_);
}

void LawLevels::Level::make(Mat h, const SingleLevel& of) {
  rows = rows_with_entries(h);
  of.interpolation->only(rows, interpolation);
  check(MatPtAP(h, interpolation.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, next.put()));
}

void LawLevels::Level::refresh(Mat h) {
  Mat there = next.get();
  check(MatPtAP(h, interpolation.get(), MAT_REUSE_MATRIX, PETSC_DEFAULT, &there));
}

Mat LawLevels::spread(const std::vector<SingleLevel>& levels) {
  if (!any_) {
    for (const SingleLevel& level : levels) level.matrix->add(nullptr, {});
    return nullptr;
  }
  levels_.resize(levels.size());
  Mat h = finest_.get();
  for (std::size_t l = 0; l < levels.size(); ++l) {
    Level& level = levels_[l];
    if (level.next)
      level.refresh(h);
    else
      level.make(h, levels[l]);
    levels[l].matrix->add(h, level.rows);
    h = level.next.get();
  }
  return h;
}

double LawLevels::bytes() const {
  double out = finest_ ? bytes_of(finest_.get()) : 0.0;
  for (const Level& level : levels_)
    if (level.next) out += bytes_of(level.next.get()) + bytes_of(level.interpolation.get());
  return out;
}

} // namespace hvi::petsc_module
