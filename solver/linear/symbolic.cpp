// See symbolic.hpp.
#include "solver/linear/symbolic.hpp"

#include <algorithm>

namespace hvi::solver {

cholmod_factor* symbolic_factor(ContactLastOrder& order, CholmodSession& session) {
  cholmod_common* common = session.common();
  cholmod_factor* l = cholmod_l_allocate_factor(order.permutation.size(), common);
  if (l == nullptr) return nullptr;
  l->ordering = CHOLMOD_GIVEN;
  std::ranges::copy(order.permutation, static_cast<Long*>(l->Perm));
  std::ranges::copy(order.count, static_cast<Long*>(l->ColCount));
  cholmod_sparse upper = order.above.view(1);
  if (cholmod_l_super_symbolic2(CHOLMOD_ANALYZE_FOR_CHOLESKY, &upper, nullptr, order.parent.data(),
                                l, common) == 0)
    cholmod_l_free_factor(&l, common);
  return l;
}

} // namespace hvi::solver
