// The factor L by CHOLMOD (cholesky_factor.hpp).
//
// Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, Algorithm 887: CHOLMOD, supernodal sparse
// Cholesky factorization and update/downdate, ACM Trans. Math. Softw. 35 (2008).
#include "solver/linear/cholesky_factor.hpp"

#include "solver/common/out_of_memory.hpp"
#include "solver/linear/blas_threads.hpp"
#include "solver/linear/large_pages.hpp"
#include "solver/linear/left_looking.hpp"
#include "solver/linear/ordering.hpp"
#include "solver/linear/symbolic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

CholeskyFactor::CholeskyFactor(const SparseMatrix& k, std::span<const int> contact,
                               OrderStore* known, FactorEntries entries,
                               FactorStatistics& statistics)
    : entries_(entries) {
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

CholeskyFactor::CholeskyFactor(const CholeskyFactor& analysed)
    : entries_(analysed.entries_), factor_(analysed.factor_), a_(analysed.a_),
      order_(analysed.order_) {}

double CholeskyFactor::bytes() const {
  const cholmod_factor& l = structure();
  const double contacts = order_.contacts(); // L22 and S
  const std::size_t entry = entries_ == FactorEntries::singles ? sizeof(float) : sizeof(double);
  return static_cast<double>(l.xsize) * static_cast<double>(entry) +
         static_cast<double>(l.ssize) * (sizeof(Long) + sizeof(int)) +
         contacts * contacts * static_cast<double>(entry + sizeof(double));
}

std::size_t CholeskyFactor::interior_entries() const {
  const cholmod_factor& l = structure();
  if (order_.contacts() == 0) return l.xsize;
  const auto [super, row_start, value_start, row] = arrays_of(l);
  const auto last = std::upper_bound(super, super + l.nsuper, Long{order_.interior}) - 1;
  const auto s = last - super; // whose columns from the first contact one on stand at the end
  return static_cast<std::size_t>(value_start[s] +
                                  (order_.interior - *last) * (row_start[s + 1] - row_start[s]));
}

void CholeskyFactor::take_doubles() {
  entries_ = FactorEntries::doubles;
  LargeVector<float>().swap(singles_);
}

void CholeskyFactor::make_room() {
  cholmod_factor* l = factor_.l;
  if (entries_ == FactorEntries::singles) {
    singles_.resize(l->xsize);
    return;
  }
  cholmod_common* common = factor_.session.common();
  if (l->xtype != CHOLMOD_PATTERN) return;
  if (cholmod_l_change_factor(CHOLMOD_REAL, true, true, true, true, l, common) == 0) {
    const auto size = order_.size();
    refuse_too_large(*common, size);
    throw OutOfMemory("no memory to factor a matrix of {} unknowns ({:.2g} bytes)", size, bytes());
  }
  advise_large_pages(l->x, l->xsize * sizeof(double));
}

bool CholeskyFactor::compute(const SparseMatrix& k) {
  const OneBlasThread one_thread;
  a_.assign(k);
  make_room();
  cholmod_factor* l = factor_.l;
  const int interior = order_.interior;
  const Long failed = entries_ == FactorEntries::singles
                          ? factor_left_looking(a_, *l, interior, singles_.data())
                          : factor_left_looking(a_, *l, interior, static_cast<double*>(l->x));
  l->minor = static_cast<std::size_t>(failed);
  return failed == interior;
}

/// Reads the diagonal, which lies scattered in memory, once; then nothing but L is kept.
void CholeskyFactor::take_diagonal(std::span<const double> contact, std::vector<double>& inverse) {
  const auto known = static_cast<int>(factor_.l->minor) + static_cast<int>(contact.size());
  if (known < order_.size()) fail_at(known, 0.0);
  double least = std::numeric_limits<double>::infinity();
  int where = -1;
  const auto check = [&](int position, double entry) {
    const double pivot = entry * entry / a_.diagonal()[position];
    if (!std::isfinite(pivot)) fail_at(position, pivot);
    if (pivot >= least) return;
    least = pivot;
    where = position;
  };
  const auto [super, row_start, value_start, row] = arrays_of(structure());
  for (std::size_t s = 0; s < factor_.l->nsuper && super[s] < order_.interior; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    const Long end = std::min<Long>(super[s + 1], order_.interior);
    for (Long position = super[s]; position < end; ++position) {
      const std::size_t at = value_start[s] + (position - super[s]) * (stride + 1);
      const double entry = with_values([&](const auto* values) { return double{values[at]}; });
      check(static_cast<int>(position), entry);
      inverse[position] = 1.0 / entry;
    }
  }
  for (std::size_t i = 0; i < contact.size(); ++i)
    check(order_.interior + static_cast<int>(i), contact[i]);
  if (least < smallest_pivot) fail_at(where, least);
  a_.forget_values();
}

void CholeskyFactor::fail_at(int position, double pivot) const {
  const bool known = position >= 0 && position < order_.size();
  throw NotFactorable(known ? order_.unknown[position] : -1, pivot,
                      "the matrix is not positive definite: the elimination breaks down");
}

/// Gathers the contact columns, which lie in one or several supernodes, into a dense S.
template <class Entry>
void CholeskyFactor::take_trailing_block(SquareOf<Entry>& out) {
  const auto contacts = order_.contacts();
  out.setZero(contacts, contacts);
  const auto [super, row_start, value_start, row] = arrays_of(structure());
  for (std::size_t s = 0; s < factor_.l->nsuper; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    for (Long column = std::max<Long>(super[s], order_.interior); column < super[s + 1]; ++column)
      for (Long i = column - super[s]; i < stride; ++i)
        out(row[row_start[s] + i] - order_.interior, column - order_.interior) =
            values<Entry>()[value_start[s] + (column - super[s]) * stride + i];
  }
  if (contacts == 0) return;
  const std::size_t kept = interior_entries();
  give_back_pages(const_cast<Entry*>(values<Entry>()) + kept,
                  (factor_.l->xsize - kept) * sizeof(Entry));
}

template void CholeskyFactor::take_trailing_block(SquareOf<double>&);
template void CholeskyFactor::take_trailing_block(SquareOf<float>&);

} // namespace hvi::solver
