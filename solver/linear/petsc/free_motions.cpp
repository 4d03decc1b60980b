// See free_motions.hpp.
#include "solver/linear/petsc/free_motions.hpp"

#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace hvi::petsc_module {
namespace {

/// Of a column of N^T A N: what elimination leaves of it where A takes the motion to 0.
constexpr double rounding = 1e-14;

} // namespace

FreeMotions::FreeMotions(const Distribution& distribution, std::vector<double> motions, int count)
    : distribution_(distribution), size_(motions.size() / static_cast<std::size_t>(count)),
      count_(count), motions_(std::move(motions)), moved_(motions_.size()) {}

std::vector<double> FreeMotions::products(const std::vector<double>& columns,
                                          const double* x) const {
  std::vector<double> out;
  for (int m = 0; m < count_; ++m) {
    const double* column = columns.data() + static_cast<std::size_t>(m) * size_;
    out.push_back(std::inner_product(column, column + size_, x, 0.0));
  }
  distribution_.add_up(out.data(), count_);
  return out;
}

void FreeMotions::add_columns(const std::vector<double>& columns, const std::vector<double>& by,
                              double factor, double* x) const {
  for (int m = 0; m < count_; ++m) {
    const double* column = columns.data() + static_cast<std::size_t>(m) * size_;
    const double times = factor * by[static_cast<std::size_t>(m)];
    for (std::size_t i = 0; i < size_; ++i) x[i] += times * column[i];
  }
}

bool FreeMotions::factor(Mat a) {
  small_.clear();
  for (int m = 0; m < count_; ++m) {
    const std::size_t first = static_cast<std::size_t>(m) * size_;
    Owned<Vec> from, to;
    distribution_.make(motions_.data() + first, from);
    distribution_.make(moved_.data() + first, to);
    check(MatMult(a, from.get(), to.get()));
    const std::vector<double> column = products(motions_, moved_.data() + first);
    small_.insert(small_.end(), column.begin(), column.end());
  }
  const std::vector<double> given = small_;
  pivots_.resize(static_cast<std::size_t>(count_));
  PetscBLASInt n = count_, info = 0;
  LAPACKgetrf_(&n, &n, small_.data(), &n, pivots_.data(), &info);
  return info == 0 && !any_pivot_is_rounding(given);
}

/// A pivot that is rounding of its column: the laws do not see this motion.
bool FreeMotions::any_pivot_is_rounding(const std::vector<double>& given) const {
  for (std::ptrdiff_t m = 0; m < count_; ++m) {
    const auto column = given.begin() + m * count_;
    const double largest = std::abs(*std::max_element(
        column, column + count_, [](double a, double b) { return std::abs(a) < std::abs(b); }));
    const double pivot = std::abs(small_[static_cast<std::size_t>(m * (count_ + 1))]);
    if (!(pivot > rounding * largest)) return true;
  }
  return false;
}

void FreeMotions::solve(std::vector<double>& right) const {
  PetscBLASInt n = count_, one = 1, info = 0;
  LAPACKgetrs_("N", &n, &one, small_.data(), &n, pivots_.data(), right.data(), &n, &info);
}

PetscErrorCode FreeMotions::remove(Vec r, Vec out) {
  double* left = nullptr;
  PetscCall(VecCopy(r, out));
  PetscCall(VecGetArray(out, &left));
  amplitudes_ = products(motions_, left);
  solve(amplitudes_);
  add_columns(moved_, amplitudes_, -1.0, left);
  PetscCall(VecRestoreArray(out, &left));
  return 0;
}

PetscErrorCode FreeMotions::add(bool project, Vec z) {
  double* to = nullptr;
  PetscCall(VecGetArray(z, &to));
  if (project) {
    std::vector<double> of_z = products(moved_, to);
    solve(of_z);
    for (std::size_t m = 0; m < of_z.size(); ++m) amplitudes_[m] -= of_z[m];
  }
  add_columns(motions_, amplitudes_, 1.0, to);
  PetscCall(VecRestoreArray(z, &to));
  return 0;
}

double FreeMotions::bytes() const {
  return static_cast<double>(motions_.size() + moved_.size() + small_.size()) * sizeof(double);
}

} // namespace hvi::petsc_module
