// The factor L by CHOLMOD (cholesky_factor.hpp).
//
// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse
// Cholesky factorization and update/downdate, ACM Trans. Math. Softw. 35 (2008).
#include "solver/linear/cholesky_factor.hpp"

#include "solver/common/out_of_memory.hpp"
#include "solver/linear/large_pages.hpp"
#include "solver/linear/left_looking.hpp"
#include "solver/linear/one_blas_thread.hpp"
#include "solver/linear/ordering.hpp"
#include "solver/linear/symbolic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

CholeskyFactor::CholeskyFactor(const SparseMatrix& k, std::span<const int> contact,
                               OrderStore* known, FactorStatistics& statistics) {
  CholmodSession& session = factor_.session;
  {
    auto order = known != nullptr ? known->order(k, contact, session)
                                  : order_contact_last(k, contact, session);
    factor_.l = symbolic_factor(order, session);
    cholmod_l_free_work(session.common()); // what comes next may take the place of both
    if (factor_.l == nullptr || factor_.l->is_super == 0) {
      const auto size = static_cast<int>(k.rows());
      refuse_too_large(*session.common(), size);
      throw OutOfMemory("no memory to analyse a matrix of {} unknowns", size);
    }
    order_ = elimination_order(order, contact);
    statistics.nonzeros = order.nonzeros;
    statistics.flops = order.flops;
    statistics.ordering = std::move(order.name);
  }
  a_ = PermutedLower(k, order_.unknown);
}

double CholeskyFactor::bytes() const {
  const cholmod_factor& l = structure();
  const double contacts = order_.contacts(); // L22 and S
  return static_cast<double>(l.xsize) * sizeof(double) +
         static_cast<double>(l.ssize) * (sizeof(Long) + sizeof(int)) +
         2.0 * contacts * contacts * sizeof(double);
}

void CholeskyFactor::compute(const SparseMatrix& k) {
  const OneBlasThread one_thread;
  a_.assign(k);
  cholmod_factor* l = factor_.l;
  cholmod_common* common = factor_.session.common();
  if (l->xtype == CHOLMOD_PATTERN) {
    if (cholmod_l_change_factor(CHOLMOD_REAL, true, true, true, true, l, common) == 0) {
      const auto size = order_.size();
      refuse_too_large(*common, size);
      throw OutOfMemory("no memory to factor a matrix of {} unknowns ({:.2g} bytes)", size,
                        bytes());
    }
    advise_large_pages(l->x, l->xsize * sizeof(double));
  }
  l->minor = static_cast<std::size_t>(factor_left_looking(a_, *l));
}

/// Reads the diagonal, which lies scattered in memory, once; then nothing but L is kept.
void CholeskyFactor::take_diagonal(std::vector<double>& inverse) {
  if (factor_.l->minor < factor_.l->n) fail_at(static_cast<int>(factor_.l->minor), 0.0);
  const auto [super, row_start, value_start, row] = arrays_of(structure());
  double least = std::numeric_limits<double>::infinity();
  int where = -1;
  for (std::size_t s = 0; s < factor_.l->nsuper; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    for (Long position = super[s]; position < super[s + 1]; ++position) {
      const double entry = values()[value_start[s] + (position - super[s]) * (stride + 1)];
      const double pivot = entry * entry / a_.diagonal()[position];
      if (!std::isfinite(pivot)) fail_at(static_cast<int>(position), pivot);
      if (pivot < least) {
        least = pivot;
        where = static_cast<int>(position);
      }
      if (position < order_.interior) inverse[position] = 1.0 / entry;
    }
  }
  if (least < smallest_pivot) fail_at(where, least);
  a_.forget_values();
}

void CholeskyFactor::fail_at(int position, double pivot) const {
  const bool known = position >= 0 && position < order_.size();
  throw NotFactorable(known ? order_.unknown[position] : -1, pivot,
                      "the matrix is not positive definite: the elimination breaks down");
}

/// Gathers the contact columns, which lie in one or several supernodes, into a dense L22.
void CholeskyFactor::take_trailing_block(DenseMatrix& l22) const {
  const auto contacts = order_.contacts();
  l22.setZero(contacts, contacts);
  const auto [super, row_start, value_start, row] = arrays_of(structure());
  for (std::size_t s = 0; s < factor_.l->nsuper; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    for (Long column = std::max<Long>(super[s], order_.interior); column < super[s + 1]; ++column)
      for (Long i = column - super[s]; i < stride; ++i)
        l22(row[row_start[s] + i] - order_.interior, column - order_.interior) =
            values()[value_start[s] + (column - super[s]) * stride + i];
  }
}

} // namespace hvi::solver
