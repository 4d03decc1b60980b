// See cholmod_session.hpp.
#include "solver/linear/cholmod_session.hpp"

#include "solver/common/failure.hpp"

#include <omp.h>

#include <algorithm>

extern "C" {
void openblas_set_num_threads(int threads);
int openblas_get_num_threads(void);
}

namespace hvi::solver {

CholmodSession::CholmodSession() {
  cholmod_l_start(&common_);
  common_.print = 0;
  common_.useGPU = 0;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.final_ll = 1;
}

CholmodSession::~CholmodSession() { cholmod_l_finish(&common_); }

OneBlasThread::OneBlasThread()
    : before_(openblas_get_num_threads()), levels_before_(omp_get_max_active_levels()) {
  if (before_ != 1) openblas_set_num_threads(1);
  // CHOLMOD's loops ask for four threads by name; with no active level allowed they get one.
  omp_set_max_active_levels(0);
}

OneBlasThread::~OneBlasThread() {
  if (before_ != 1) openblas_set_num_threads(before_);
  omp_set_max_active_levels(levels_before_);
}

UpperTriangle::UpperTriangle(const SparseMatrix& k, std::span<const std::pair<int, int>> extra)
    : size_(static_cast<std::size_t>(k.rows())),
      entries_of_k_(static_cast<std::size_t>(k.nonZeros())) {
  std::vector<std::pair<int, int>> added(extra.begin(), extra.end()); // as (column, row)
  for (auto& [column, row] : added)
    if (column < row) std::swap(column, row);
  std::ranges::sort(added);
  start_.reserve(size_ + 1);
  row_.reserve(entries_of_k_ / 2 + size_ + added.size());
  source_.reserve(row_.capacity());
  start_.push_back(0);
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  auto next = added.begin();
  // A row of K up to its diagonal is, by symmetry, a column of the upper triangle.
  for (int column = 0; column < k.rows(); ++column) {
    for (int at = outer[column]; at < outer[column + 1]; ++at) {
      if (inner[at] > column) continue;
      row_.push_back(inner[at]);
      source_.push_back(at);
    }
    for (; next != added.end() && next->first == column; ++next) {
      row_.push_back(next->second);
      source_.push_back(-1);
    }
    start_.push_back(static_cast<Long>(row_.size()));
  }
  value_.assign(row_.size(), 0.0);
}

void UpperTriangle::assign(const SparseMatrix& k) {
  bool same = static_cast<std::size_t>(k.rows()) == size_ && k.isCompressed() &&
              static_cast<std::size_t>(k.nonZeros()) == entries_of_k_;
  if (same) {
    const int* inner = k.innerIndexPtr();
    const double* values = k.valuePtr();
    for (std::size_t at = 0; at < row_.size(); ++at) {
      const int from = source_[at];
      if (from < 0) continue;
      same = same && inner[from] == row_[at];
      value_[at] = values[from];
    }
  }
  if (!same)
    throw Failure(FailureKind::bad_value, {},
                  "the matrix to factor does not have the pattern that was analysed");
}

cholmod_sparse UpperTriangle::pattern() {
  cholmod_sparse a{};
  a.nrow = a.ncol = size_;
  a.nzmax = row_.size();
  a.p = start_.data();
  a.i = row_.data();
  a.stype = 1;
  a.itype = CHOLMOD_LONG;
  a.xtype = CHOLMOD_PATTERN;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 0;
  a.packed = 1;
  return a;
}

cholmod_sparse UpperTriangle::view() {
  cholmod_sparse a = pattern();
  a.x = value_.data();
  a.xtype = CHOLMOD_REAL;
  return a;
}

} // namespace hvi::solver
