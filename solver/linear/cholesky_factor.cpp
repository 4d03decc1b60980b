// The factor L by CHOLMOD (cholesky_factor.hpp).
//
// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse
// Cholesky factorization and update/downdate, ACM Trans. Math. Softw. 35 (2008).
#include "solver/linear/cholesky_factor.hpp"

#include "solver/common/out_of_memory.hpp"
#include "solver/linear/large_pages.hpp"
#include "solver/linear/one_blas_thread.hpp"
#include "solver/linear/ordering.hpp"
#include "solver/linear/symbolic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace hvi::solver {

CholeskyFactor::CholeskyFactor(const SparseMatrix& k, std::span<const int> contact,
                               OrderStore* known, FactorStatistics& statistics)
    : interior_(static_cast<int>(k.rows()) - static_cast<int>(contact.size())) {
  {
    auto order = known != nullptr ? known->order(k, contact, session_)
                                  : order_contact_last(k, contact, session_);
    l_ = symbolic_factor(order, session_);
    cholmod_l_free_work(session_.common()); // what comes next may take the place of both
    if (l_ == nullptr || l_->is_super == 0) {
      const auto size = static_cast<int>(k.rows());
      cholmod_l_free_factor(&l_, session_.common());
      refuse_too_large(*session_.common(), size);
      throw OutOfMemory("no memory to analyse a matrix of {} unknowns", size);
    }
    permutation_.assign(order.permutation.begin(), order.permutation.end());
    statistics.nonzeros = order.nonzeros;
    statistics.flops = order.flops;
    statistics.ordering = std::move(order.name);
  }
  a_ = PermutedLower(k, permutation_);
  if (!std::equal(contact.begin(), contact.end(), permutation_.begin() + interior_))
    throw std::logic_error("the postorder moved a contact unknown from the end of the elimination");
}

CholeskyFactor::CholeskyFactor(const CholeskyFactor& analysed)
    : a_(analysed.a_), interior_(analysed.interior_), permutation_(analysed.permutation_) {
  l_ = cholmod_l_copy_factor(analysed.l_, session_.common());
  // Supernodal and symbolic again: the copied values are of no use.
  const bool done = l_ != nullptr && (l_->xtype == CHOLMOD_PATTERN ||
                                      cholmod_l_change_factor(CHOLMOD_PATTERN, 1, 1, 1, 1, l_,
                                                              session_.common()) != 0);
  if (done) return;
  cholmod_l_free_factor(&l_, session_.common());
  throw OutOfMemory("no memory for one more factor of {} unknowns", permutation_.size());
}

CholeskyFactor::~CholeskyFactor() { cholmod_l_free_factor(&l_, session_.common()); }

double CholeskyFactor::bytes() const {
  const double contacts = static_cast<double>(permutation_.size()) - interior_; // L22 and S
  return static_cast<double>(l_->xsize) * sizeof(double) +
         static_cast<double>(l_->ssize) * (sizeof(Long) + sizeof(int)) +
         2.0 * contacts * contacts * sizeof(double);
}

void CholeskyFactor::compute(const SparseMatrix& k) {
  const OneBlasThread one_thread;
  a_.assign(k);
  cholmod_sparse view = a_.view();
  cholmod_common* common = session_.common();
  if (l_->xtype == CHOLMOD_PATTERN && // else CHOLMOD would make room itself, in small pages
      cholmod_l_change_factor(CHOLMOD_REAL, true, true, true, true, l_, common) != 0)
    advise_large_pages(l_->x, l_->xsize * sizeof(double));
  double nothing[2] = {0.0, 0.0}; // is added to the diagonal
  cholmod_l_super_numeric(&view, nullptr, nothing, l_, common);
  if (common->status >= CHOLMOD_OK) return;
  const auto size = static_cast<int>(permutation_.size());
  refuse_too_large(*common, size);
  throw OutOfMemory("no memory to factor a matrix of {} unknowns ({:.2g} bytes)", size, bytes());
}

/// Reads the diagonal, which lies scattered in memory, once; then nothing but L is kept.
void CholeskyFactor::take_diagonal(std::vector<double>& inverse) {
  if (session_.common()->status == CHOLMOD_NOT_POSDEF) fail_at(static_cast<int>(l_->minor), 0.0);
  const auto* super = static_cast<const Long*>(l_->super);
  const auto* row_start = static_cast<const Long*>(l_->pi);
  const auto* value_start = static_cast<const Long*>(l_->px);
  double least = std::numeric_limits<double>::infinity();
  int where = -1;
  for (std::size_t s = 0; s < l_->nsuper; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    for (Long position = super[s]; position < super[s + 1]; ++position) {
      const double entry = values()[value_start[s] + (position - super[s]) * (stride + 1)];
      const double pivot = entry * entry / a_.diagonal()[position];
      if (!std::isfinite(pivot)) fail_at(static_cast<int>(position), pivot);
      if (pivot < least) {
        least = pivot;
        where = static_cast<int>(position);
      }
      if (position < interior_) inverse[position] = 1.0 / entry;
    }
  }
  if (least < smallest_pivot) fail_at(where, least);
  cholmod_l_free_work(session_.common()); // its memory serves for the copies of the factor
  a_.forget_values();
}

void CholeskyFactor::fail_at(int position, double pivot) const {
  const bool known = position >= 0 && position < static_cast<int>(permutation_.size());
  throw NotFactorable(known ? permutation_[position] : -1, pivot,
                      "the matrix is not positive definite: the elimination breaks down");
}

/// Gathers the contact columns, which lie in one or several supernodes, into a dense L22.
void CholeskyFactor::take_trailing_block(DenseMatrix& l22) const {
  const auto contacts = static_cast<int>(permutation_.size()) - interior_;
  l22.setZero(contacts, contacts);
  const auto* super = static_cast<const Long*>(l_->super);
  const auto* row_start = static_cast<const Long*>(l_->pi);
  const auto* value_start = static_cast<const Long*>(l_->px);
  const auto* row = static_cast<const Long*>(l_->s);
  for (std::size_t s = 0; s < l_->nsuper; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    for (Long column = std::max<Long>(super[s], interior_); column < super[s + 1]; ++column)
      for (Long i = column - super[s]; i < stride; ++i)
        l22(row[row_start[s] + i] - interior_, column - interior_) =
            values()[value_start[s] + (column - super[s]) * stride + i];
  }
}

} // namespace hvi::solver
