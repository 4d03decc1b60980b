// See layers.hpp.
#include "solver/linear/petsc/layers.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::petsc_module {
namespace {

/// Marks the neighbours of what is marked.
void add_neighbours(const HviPetscMatrix& k, std::vector<char>& in) {
  const std::vector<char> before = in;
  for (int i = 0; i < k.rows; ++i)
    if (before[i] != 0)
      for (int e = k.start[i]; e < k.start[i + 1]; ++e) in[k.column[e]] = 1;
}

std::vector<int> marked(const std::vector<char>& in) {
  std::vector<int> out;
  for (std::size_t i = 0; i < in.size(); ++i)
    if (in[i] != 0) out.push_back(static_cast<int>(i));
  return out;
}

} // namespace

Layers::Layers(const HviPetscMatrix& k, const Rows& h) : k_(k), start_(h.start), column_(h.column) {
  std::vector<char> in(static_cast<std::size_t>(k.rows), 0);
  for (int i = 0; i < h.size(); ++i)
    if (h.start[i] < h.start[i + 1]) in[i] = 1;
  add_neighbours(k, in);
  inside_ = marked(in);
  position_.assign(in.size(), -1);
  for (std::size_t p = 0; p < inside_.size(); ++p) position_[inside_[p]] = static_cast<int>(p);
  add_neighbours(k, in);
  touched_ = marked(in);
}

/// K_XX + H_XX; the pattern is the union of both.
void Layers::assemble(const Rows& h, double shift) {
  Rows next;
  for (const int i : inside_) {
    int a = k_.start[i], b = h.start[i];
    const int end_a = k_.start[i + 1], end_b = h.start[i + 1];
    while (a < end_a || b < end_b) {
      const int column =
          std::min(a < end_a ? k_.column[a] : k_.rows, b < end_b ? h.column[b] : k_.rows);
      double value = 0.0;
      if (a < end_a && k_.column[a] == column) {
        value += k_.value[a] + (column == i ? shift * std::abs(k_.value[a]) : 0.0);
        ++a;
      }
      if (b < end_b && h.column[b] == column) value += h.value[b++];
      if (position_[column] < 0) continue;
      next.column.push_back(position_[column]);
      next.value.push_back(value);
    }
    next.start.push_back(static_cast<int>(next.column.size()));
  }
  if (next.start == local_.start && next.column == local_.column) {
    std::copy(next.value.begin(), next.value.end(), local_.value.begin()); // PETSc reads these
    return;
  }
  matrix_.reset();
  factor_.reset();
  local_ = std::move(next);
}

bool Layers::factor(const Rows& h, bool symmetric, double shift) {
  if (size() == 0) return true;
  assemble(h, shift);
  if (symmetric != symmetric_) factor_.reset();
  symmetric_ = symmetric;
  const PetscInt n = size();
  if (!matrix_) {
    check(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, local_.start.data(),
                                    local_.column.data(), local_.value.data(), matrix_.put()));
    check(MatCreateVecs(matrix_.get(), right_.put(), left_.put()));
  }
  values_changed(matrix_.get());
  check(MatSetOption(matrix_.get(), MAT_SYMMETRIC, symmetric ? PETSC_TRUE : PETSC_FALSE));
  MatFactorInfo info{};
  check(MatFactorInfoInitialize(&info));
  if (!factor_) {
    check(MatGetFactor(matrix_.get(), symmetric ? MATSOLVERCHOLMOD : MATSOLVERUMFPACK,
                       symmetric ? MAT_FACTOR_CHOLESKY : MAT_FACTOR_LU, factor_.put()));
    check(symmetric ? MatCholeskyFactorSymbolic(factor_.get(), matrix_.get(), nullptr, &info)
                    : MatLUFactorSymbolic(factor_.get(), matrix_.get(), nullptr, nullptr, &info));
  }
  const PetscErrorCode error = symmetric
                                   ? MatCholeskyFactorNumeric(factor_.get(), matrix_.get(), &info)
                                   : MatLUFactorNumeric(factor_.get(), matrix_.get(), &info);
  MatFactorError found = MAT_FACTOR_NOERROR;
  if (error == 0) check(MatFactorGetError(factor_.get(), &found));
  if (error == PETSC_ERR_MEM) throw std::bad_alloc();
  if (error != 0) factor_.reset();
  return error == 0 && found == MAT_FACTOR_NOERROR;
}

double Layers::bytes() const {
  MatInfo info{};
  double out = static_cast<double>(local_.column.size()) * (sizeof(double) + sizeof(int));
  if (factor_ && MatGetInfo(factor_.get(), MAT_LOCAL, &info) == 0)
    out += info.nz_used * sizeof(double);
  return out;
}

PetscErrorCode Layers::solve(const double* r, double* z) const {
  if (inside_.empty()) return 0;
  double* values = nullptr;
  PetscCall(VecGetArrayWrite(right_.get(), &values));
  for (std::size_t p = 0; p < inside_.size(); ++p) values[p] = r[inside_[p]];
  PetscCall(VecRestoreArrayWrite(right_.get(), &values));
  PetscCall(MatSolve(factor_.get(), right_.get(), left_.get()));
  const double* found = nullptr;
  PetscCall(VecGetArrayRead(left_.get(), &found));
  for (std::size_t p = 0; p < inside_.size(); ++p) z[inside_[p]] += found[p];
  PetscCall(VecRestoreArrayRead(left_.get(), &found));
  return 0;
}

double Layers::product(const Rows& h, int row, const double* z) const {
  double sum = 0.0;
  for (int e = k_.start[row]; e < k_.start[row + 1]; ++e) sum += k_.value[e] * z[k_.column[e]];
  for (int e = h.start[row]; e < h.start[row + 1]; ++e) sum += h.value[e] * z[h.column[e]];
  return sum;
}

void Layers::subtract_product(const Rows& h, const double* z, double* r) const {
  for (const int i : touched_) r[i] -= product(h, i, z);
}

void Layers::residual_inside(const Rows& h, const double* r, const double* z, double* out) const {
  for (const int i : inside_) out[i] = r[i] - product(h, i, z);
}

} // namespace hvi::petsc_module
