// See symbolic.hpp.
#include "solver/linear/symbolic.hpp"

namespace hvi::solver {

cholmod_factor* symbolic_factor(const SparseMatrix& k, const ContactLastOrder& order,
                                CholmodSession& session) {
  cholmod_common* common = session.common();
  const std::size_t n = order.permutation.size();
  const auto tree = elimination_tree(k, order.links, order.permutation, session);
  cholmod_factor* l = cholmod_l_allocate_factor(n, common);
  if (l == nullptr) return nullptr;
  l->ordering = CHOLMOD_GIVEN;
  auto* permutation = static_cast<Long*>(l->Perm);
  auto* count = static_cast<Long*>(l->ColCount);
  std::vector<Long> position(n), parent(n);
  for (std::size_t j = 0; j < n; ++j) position[tree.post[j]] = static_cast<Long>(j);
  for (std::size_t j = 0; j < n; ++j) {
    const Long before = tree.post[j], above = tree.parent[before];
    permutation[j] = order.permutation[before];
    count[j] = tree.count[before];
    parent[j] = above < 0 ? -1 : position[above];
  }
  auto final_triangle = triangle(k, order.links, {permutation, n}, true);
  cholmod_sparse upper = final_triangle.view(1);
  if (cholmod_l_super_symbolic2(CHOLMOD_ANALYZE_FOR_CHOLESKY, &upper, nullptr, parent.data(), l,
                                common) == 0)
    cholmod_l_free_factor(&l, common);
  return l;
}

} // namespace hvi::solver
