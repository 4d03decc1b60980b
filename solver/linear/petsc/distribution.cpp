// See distribution.hpp.
#include "solver/linear/petsc/distribution.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace hvi::petsc_module {
namespace {

std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> out(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), out.begin() + 1);
  return out;
}

} // namespace

Distribution::Distribution(const Numbering& numbering)
    : Distribution(world(), numbering.counts(), numbering.components()) {}

Distribution::Distribution(MPI_Comm comm, std::vector<int> counts, int components)
    : comm_(comm), rank_(rank()), components_(of_first(components)) {
  counts.resize(static_cast<std::size_t>(processes()), 0);
  MPI_Bcast(counts.data(), static_cast<int>(counts.size()), MPI_INT, 0, comm_);
  first_ = starts_of(counts);
}

int Distribution::process_of(int row) const {
  return static_cast<int>(std::upper_bound(first_.begin(), first_.end(), row) - first_.begin()) - 1;
}

int Distribution::of_first(int value) const {
  MPI_Bcast(&value, 1, MPI_INT, 0, comm_);
  return value;
}

void Distribution::add_up(double* values, int count) const {
  MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_DOUBLE, MPI_SUM, comm_);
}

double Distribution::sum(double value) const {
  add_up(&value, 1);
  return value;
}

void Distribution::largest(double* values, int count) const {
  MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_DOUBLE, MPI_MAX, comm_);
}

double Distribution::largest(double value) const {
  largest(&value, 1);
  return value;
}

bool Distribution::any(bool here) const {
  int value = here ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT, MPI_MAX, comm_);
  return value != 0;
}

std::vector<int> Distribution::counts() const {
  std::vector<int> out;
  for (std::size_t p = 0; p + 1 < first_.size(); ++p) out.push_back(first_[p + 1] - first_[p]);
  return out;
}

template <class T>
void Distribution::scatter(const T* whole, const std::vector<int>& counts, std::vector<T>& mine,
                           MPI_Datatype type) const {
  const std::vector<int> starts = starts_of(counts);
  mine.resize(static_cast<std::size_t>(counts[rank_]));
  MPI_Scatterv(whole, counts.data(), starts.data(), type, mine.data(), counts[rank_], type, 0,
               comm_);
}

void Distribution::send(const Rows& part, int to) const {
  const int entries = part.start.back();
  MPI_Send(part.start.data(), part.size() + 1, MPI_INT, to, 0, comm_);
  MPI_Send(part.column.data(), entries, MPI_INT, to, 0, comm_);
  MPI_Send(part.value.data(), entries, MPI_DOUBLE, to, 0, comm_);
}

void Distribution::receive(Rows& mine, int rows, int from) const {
  mine.start.resize(static_cast<std::size_t>(rows) + 1);
  MPI_Recv(mine.start.data(), rows + 1, MPI_INT, from, 0, comm_, MPI_STATUS_IGNORE);
  const int entries = mine.start.back();
  mine.column.resize(static_cast<std::size_t>(entries));
  mine.value.resize(static_cast<std::size_t>(entries));
  MPI_Recv(mine.column.data(), entries, MPI_INT, from, 0, comm_, MPI_STATUS_IGNORE);
  MPI_Recv(mine.value.data(), entries, MPI_DOUBLE, from, 0, comm_, MPI_STATUS_IGNORE);
}

/// The first process makes one part after the other, so that it never has a second copy of all.
HviPetscMatrix Distribution::deal(const WholeMatrix& whole, Rows& mine) const {
  if (alone() && whole.as_it_is() != nullptr) return *whole.as_it_is();
  if (!is_first()) {
    receive(mine, rows(), 0);
    return mine.view();
  }
  for (int p = 1; p + 1 < static_cast<int>(first_.size()); ++p)
    send(whole.part(first_[p], first_[p + 1]), p);
  mine = whole.part(first_[0], first_[1]);
  return mine.view();
}

std::vector<int> Distribution::deal(const std::vector<int>& whole) const {
  std::vector<int> mine;
  scatter(whole.data(), counts(), mine, MPI_INT);
  return mine;
}

std::vector<double> Distribution::deal(std::vector<double> columns, int count) const {
  if (alone()) return columns;
  std::vector<double> out, column;
  for (int m = 0; m < count; ++m) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(m) * all_rows();
    scatter(is_first() ? columns.data() + first : nullptr, counts(), column, MPI_DOUBLE);
    out.insert(out.end(), column.begin(), column.end());
  }
  return out;
}

Rows Distribution::fetch(const std::vector<int>& named, Mat matrix) const {
  std::vector<int> all = named;
  all.resize(static_cast<std::size_t>(of_first(static_cast<int>(named.size()))));
  MPI_Bcast(all.data(), static_cast<int>(all.size()), MPI_INT, 0, comm_);
  Rows mine;
  for (const int i : all) {
    if (process_of(i) != rank_) continue;
    PetscInt count = 0;
    const PetscInt* column = nullptr;
    const PetscScalar* value = nullptr;
    check(MatGetRow(matrix, i, &count, &column, &value));
    mine.column.insert(mine.column.end(), column, column + count);
    mine.value.insert(mine.value.end(), value, value + count);
    mine.start.push_back(static_cast<int>(mine.column.size()));
    check(MatRestoreRow(matrix, i, &count, &column, &value));
  }
  if (!is_first()) {
    if (mine.size() > 0) send(mine, 0);
    return {};
  }
  return in_order(all, std::move(mine));
}

/// The named rows, of which `mine` are here and each other process sends its own.
Rows Distribution::in_order(const std::vector<int>& named, Rows mine) const {
  std::vector<int> counts(first_.size() - 1, 0), next(counts.size(), 0);
  for (const int i : named) ++counts[process_of(i)];
  std::vector<Rows> of(counts.size());
  of.front() = std::move(mine);
  for (std::size_t p = 1; p < of.size(); ++p)
    if (counts[p] > 0) receive(of[p], counts[p], static_cast<int>(p));
  Rows out;
  for (const int i : named) {
    const int p = process_of(i), at = next[p]++;
    const Rows& from = of[p];
    out.column.insert(out.column.end(), from.column.begin() + from.start[at],
                      from.column.begin() + from.start[at + 1]);
    out.value.insert(out.value.end(), from.value.begin() + from.start[at],
                     from.value.begin() + from.start[at + 1]);
    out.start.push_back(static_cast<int>(out.column.size()));
  }
  return out;
}

void Distribution::make(const HviPetscMatrix& mine, Owned<Mat>& matrix) const {
  if (alone()) {
    check(MatCreateSeqAIJWithArrays(comm_, mine.rows, mine.rows, const_cast<int*>(mine.start),
                                    const_cast<int*>(mine.column), const_cast<double*>(mine.value),
                                    matrix.put()));
    check(MatSetBlockSize(matrix.get(), components_));
    return;
  }
  check(MatCreate(comm_, matrix.put()));
  check(MatSetSizes(matrix.get(), rows(), rows(), all_rows(), all_rows()));
  check(MatSetType(matrix.get(), MATMPIAIJ));
  check(MatSetBlockSize(matrix.get(), components_));
  check(MatMPIAIJSetPreallocationCSR(matrix.get(), mine.start, mine.column, mine.value));
}

void Distribution::refresh(const HviPetscMatrix& mine, Mat matrix) const {
  if (alone())
    values_changed(matrix);
  else
    check(MatUpdateMPIAIJWithArray(matrix, mine.value));
}

double Distribution::copied_bytes(Mat matrix) const { return alone() ? 0.0 : bytes_of(matrix); }

void Distribution::make(double* values, Owned<Vec>& vector) const {
  check(alone() ? VecCreateSeqWithArray(comm_, 1, rows(), values, vector.put())
                : VecCreateMPIWithArray(comm_, 1, rows(), all_rows(), values, vector.put()));
}

} // namespace hvi::petsc_module
