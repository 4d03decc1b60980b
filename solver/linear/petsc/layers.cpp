// See layers.hpp.
#include "solver/linear/petsc/layers.hpp"

#include "solver/linear/petsc/partition.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace hvi::petsc_module {
namespace {

std::vector<int> marked(const std::vector<char>& in) {
  std::vector<int> out;
  for (std::size_t i = 0; i < in.size(); ++i)
    if (in[i] != 0) out.push_back(static_cast<int>(i));
  return out;
}

/// Marks the neighbours of what is marked.
void add_neighbours(const WholeMatrix& k, std::vector<char>& in) {
  const std::vector<int> before = marked(in);
  k.need(before);
  WholeMatrix::Room room;
  for (const int i : before) {
    const WholeMatrix::Row row = k.row(i, room);
    for (int e = 0; e < row.size; ++e) in[row.column[e]] = 1;
  }
}

bool has_entries(const Rows& h, int row) { return h.start[row] < h.start[row + 1]; }

/// For each row the first one that h couples it with, over any number of others.
std::vector<int> first_coupled(const Rows& h) {
  std::vector<int> parent(static_cast<std::size_t>(h.size()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (int i = 0; i < h.size(); ++i)
    for (int e = h.start[i]; e < h.start[i + 1]; ++e) {
      const int a = root(i), b = root(h.column[e]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  for (int i = 0; i < h.size(); ++i) parent[i] = root(i);
  return parent;
}

/// The rows that are named, and none of the others.
Rows only(const WholeMatrix& k, const std::vector<int>& named) {
  k.need(named);
  Rows out;
  out.start.assign(static_cast<std::size_t>(k.rows()) + 1, 0);
  WholeMatrix::Room room;
  for (const int i : named) {
    const WholeMatrix::Row row = k.row(i, room);
    out.start[i + 1] = row.size;
    out.column.insert(out.column.end(), row.column, row.column + row.size);
    out.value.insert(out.value.end(), row.value, row.value + row.size);
  }
  std::partial_sum(out.start.begin(), out.start.end(), out.start.begin());
  return out;
}

} // namespace

Layers::Layers(const Distribution& distribution, Vec like, const WholeMatrix& k, const Rows& h)
    : distribution_(distribution), k_(k), start_(h.start), column_(h.column) {
  const std::vector<int> counts = find(h);
  parts_.emplace(distribution.comm(), counts);
  near_.set(distribution_, like, near_rows_.view());
  const std::vector<int> mine = parts_->deal(inside_);
  const PetscInt n = parts_->rows();
  check(VecCreateSeq(PETSC_COMM_SELF, n, right_.put()));
  check(VecCreateSeq(PETSC_COMM_SELF, n, left_.put()));
  connect(like, mine, right_.get(), scatter_);
}

/// X and what is beside it; how many rows of X each process has.
std::vector<int> Layers::find(const Rows& h) {
  std::vector<char> in(static_cast<std::size_t>(k_.rows()), 0);
  for (int i = 0; i < h.size(); ++i)
    if (has_entries(h, i)) in[i] = 1;
  add_neighbours(k_, in);
  inside_ = marked(in);
  add_neighbours(k_, in);
  beside_ = marked(in);
  near_rows_ = only(k_, beside_);
  part_ = parts_of(h);
  std::stable_sort(inside_.begin(), inside_.end(),
                   [&](int a, int b) { return part_[a] < part_[b]; });
  position_.assign(in.size(), -1);
  for (std::size_t p = 0; p < inside_.size(); ++p) position_[inside_[p]] = static_cast<int>(p);
  std::vector<int> counts(static_cast<std::size_t>(processes()), 0);
  for (const int i : inside_) ++counts[part_[i]];
  return counts;
}

/// Which process solves for each row of X: parts of alike size, with what h couples in one, and a
/// neighbour of it with the first one that it neighbours. Whose rows of K they are does not matter:
/// a process far from the contact would wait for those which are there.
std::vector<int> Layers::parts_of(const Rows& h) const {
  const HviPetscMatrix k = near_rows_.view();
  std::vector<int> out(static_cast<std::size_t>(k.rows), 0);
  if (distribution_.alone()) return out;
  const std::vector<int> with = first_coupled(h);
  std::vector<int> vertex(out.size(), -1), weight; // of the graph of what is coupled
  std::vector<int> of(out.size(), -1);             // the vertex of each row of X
  for (const int i : inside_) {
    int law = i;
    for (int e = k.start[i]; !has_entries(h, law) && e < k.start[i + 1]; ++e)
      if (has_entries(h, k.column[e])) law = k.column[e];
    int& number = vertex[with[law]];
    if (number < 0) number = static_cast<int>(weight.size()), weight.push_back(0);
    ++weight[of[i] = number];
  }
  std::vector<std::vector<int>> neighbours(weight.size());
  for (const int i : inside_)
    for (int e = k.start[i]; e < k.start[i + 1]; ++e)
      if (const int other = of[k.column[e]]; other >= 0 && other != of[i]) {
        neighbours[of[i]].push_back(other);
        neighbours[other].push_back(of[i]);
      }
  const std::vector<int> part =
      petsc_module::parts_of(Graph(std::move(neighbours)), std::move(weight), processes());
  for (const int i : inside_) out[i] = part[of[i]];
  return out;
}

void Layers::matrix_changed(Vec like) {
  near_rows_ = only(k_, beside_);
  near_.set(distribution_, like, near_rows_.view());
}

/// K_XX + H_XX without the entries between parts; the pattern is the union of both, and K has all
/// its diagonal.
Rows Layers::assembled(const Rows& h, double shift) const {
  const HviPetscMatrix k = near_rows_.view();
  Rows out;
  for (const int i : inside_) {
    int a = k.start[i], b = h.start[i];
    const int end_a = k.start[i + 1], end_b = h.start[i + 1];
    std::size_t diagonal = 0;
    double left_out = 0.0;
    while (a < end_a || b < end_b) {
      const int column =
          std::min(a < end_a ? k.column[a] : k.rows, b < end_b ? h.column[b] : k.rows);
      double value = 0.0;
      if (a < end_a && k.column[a] == column) {
        value += k.value[a] + (column == i ? shift * std::abs(k.value[a]) : 0.0);
        ++a;
      }
      if (b < end_b && h.column[b] == column) value += h.value[b++];
      if (position_[column] < 0) continue;
      if (part_[column] != part_[i]) {
        left_out += std::abs(value);
        continue;
      }
      if (column == i) diagonal = out.value.size();
      out.column.push_back(position_[column]);
      out.value.push_back(value);
    }
    out.value[diagonal] += 0.5 * left_out;
    out.start.push_back(static_cast<int>(out.column.size()));
  }
  return out;
}

/// This process's part, in numbers of its own.
void Layers::take(Rows whole) {
  Rows mine;
  parts_->deal(whole.view(), mine);
  if (parts_->alone()) mine = std::move(whole);
  for (int& column : mine.column) column -= parts_->first_row();
  if (mine.start == local_.start && mine.column == local_.column) {
    std::copy(mine.value.begin(), mine.value.end(), local_.value.begin()); // PETSc reads these
    return;
  }
  matrix_.reset();
  factor_.reset();
  local_ = std::move(mine);
}

bool Layers::factor(const Rows& h, bool symmetric, double shift) {
  take(assembled(h, shift));
  if (symmetric != symmetric_) factor_.reset();
  symmetric_ = symmetric;
  return !distribution_.any(!factored());
}

bool Layers::factored() {
  const PetscInt n = local_.size();
  if (n == 0) return true;
  if (!matrix_)
    check(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, local_.start.data(),
                                    local_.column.data(), local_.value.data(), matrix_.put()));
  values_changed(matrix_.get());
  check(MatSetOption(matrix_.get(), MAT_SYMMETRIC, symmetric_ ? PETSC_TRUE : PETSC_FALSE));
  MatFactorInfo info{};
  check(MatFactorInfoInitialize(&info));
  if (!factor_) {
    check(MatGetFactor(matrix_.get(), symmetric_ ? MATSOLVERCHOLMOD : MATSOLVERUMFPACK,
                       symmetric_ ? MAT_FACTOR_CHOLESKY : MAT_FACTOR_LU, factor_.put()));
    check(symmetric_ ? MatCholeskyFactorSymbolic(factor_.get(), matrix_.get(), nullptr, &info)
                     : MatLUFactorSymbolic(factor_.get(), matrix_.get(), nullptr, nullptr, &info));
  }
  const PetscErrorCode error = symmetric_
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
  double out =
      near_.bytes() + static_cast<double>(local_.column.size() + near_rows_.column.size()) *
                          (sizeof(double) + sizeof(int));
  if (factor_ && MatGetInfo(factor_.get(), MAT_LOCAL, &info) == 0)
    out += info.nz_used * sizeof(double);
  return out;
}

PetscErrorCode Layers::add_solved(Vec r, Vec z) const {
  const VecScatter scatter = scatter_.get();
  const Vec right = right_.get(), left = left_.get();
  PetscCall(VecScatterBegin(scatter, r, right, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(scatter, r, right, INSERT_VALUES, SCATTER_FORWARD));
  if (local_.size() > 0) PetscCall(MatSolve(factor_.get(), right, left));
  PetscCall(VecScatterBegin(scatter, left, z, ADD_VALUES, SCATTER_REVERSE));
  return VecScatterEnd(scatter, left, z, ADD_VALUES, SCATTER_REVERSE);
}

} // namespace hvi::petsc_module
