// See cholmod_session.hpp.
#include "solver/linear/cholmod_session.hpp"

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
    : size_(static_cast<std::size_t>(k.rows())) {
  std::vector<std::pair<int, int>> added(extra.begin(), extra.end()); // as (column, row)
  for (auto& [column, row] : added)
    if (column < row) std::swap(column, row);
  std::ranges::sort(added);
  start_.reserve(size_ + 1);
  row_.reserve(static_cast<std::size_t>(k.nonZeros()) / 2 + size_ + added.size());
  start_.push_back(0);
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  auto next = added.begin();
  // A row of K up to its diagonal is, by symmetry, a column of the upper triangle.
  for (int column = 0; column < k.rows(); ++column) {
    for (int at = outer[column]; at < outer[column + 1]; ++at)
      if (inner[at] <= column) row_.push_back(inner[at]);
    for (; next != added.end() && next->first == column; ++next) row_.push_back(next->second);
    start_.push_back(static_cast<Long>(row_.size()));
  }
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

} // namespace hvi::solver
