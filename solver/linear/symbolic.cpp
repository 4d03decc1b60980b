// See symbolic.hpp.
#include "solver/linear/symbolic.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

/// A triangle of P K P^T by columns, rows in any order.
struct Triangle {
  std::vector<Long> start{0}, row;

  cholmod_sparse view(int stype) {
    cholmod_sparse a{};
    a.nrow = a.ncol = start.size() - 1;
    a.nzmax = row.size();
    a.p = start.data();
    a.i = row.data();
    a.stype = stype;
    a.itype = CHOLMOD_LONG;
    a.xtype = CHOLMOD_PATTERN;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = 0;
    a.packed = 1;
    return a;
  }
};

/// Links by position: (column, row) of one triangle, sorted.
std::vector<std::pair<Long, Long>> placed(const ContactLastOrder& order,
                                          std::span<const Long> position, bool upper) {
  std::vector<std::pair<Long, Long>> out;
  for (const auto& [a, b] : order.links) {
    const auto [low, high] = std::minmax(position[a], position[b]);
    out.emplace_back(upper ? high : low, upper ? low : high);
  }
  std::ranges::sort(out);
  return out;
}

/// Row u of K holds, by symmetry, column u: both triangles are there to be picked.
Triangle triangle(const SparseMatrix& k, const ContactLastOrder& order,
                  std::span<const Long> permutation, bool upper) {
  const auto n = static_cast<Long>(permutation.size());
  std::vector<Long> position(permutation.size());
  for (Long j = 0; j < n; ++j) position[permutation[j]] = j;
  const auto links = placed(order, position, upper);
  auto next = links.begin();
  Triangle out;
  out.start.reserve(permutation.size() + 1);
  out.row.reserve((static_cast<std::size_t>(k.nonZeros()) + permutation.size()) / 2 + links.size());
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  for (Long j = 0; j < n; ++j) {
    const Long unknown = permutation[j];
    for (int at = outer[unknown]; at < outer[unknown + 1]; ++at)
      if (const Long i = position[inner[at]]; upper ? i <= j : i >= j) out.row.push_back(i);
    for (; next != links.end() && next->first == j; ++next) out.row.push_back(next->second);
    out.start.push_back(static_cast<Long>(out.row.size()));
  }
  return out;
}

/// Elimination tree and column counts in one order, and the postorder that belongs to them.
struct Tree {
  std::vector<Long> parent, post, count;
};

bool find_tree(const SparseMatrix& k, const ContactLastOrder& order, cholmod_common* common,
               Tree& tree) {
  const std::size_t n = order.permutation.size();
  std::vector<Long> first(n), level(n);
  tree.parent.resize(n), tree.post.resize(n), tree.count.resize(n);
  const auto all = static_cast<Long>(n);
  {
    auto above = triangle(k, order, order.permutation, true);
    cholmod_sparse upper = above.view(1);
    if (cholmod_l_etree(&upper, tree.parent.data(), common) == 0) return false;
  }
  auto below = triangle(k, order, order.permutation, false);
  cholmod_sparse lower = below.view(-1);
  return cholmod_l_postorder(tree.parent.data(), n, nullptr, tree.post.data(), common) == all &&
         cholmod_l_rowcolcounts(&lower, nullptr, 0, tree.parent.data(), tree.post.data(), nullptr,
                                tree.count.data(), first.data(), level.data(), common) != 0 &&
         // Children with large columns come last: what they pass on is still in the cache.
         cholmod_l_postorder(tree.parent.data(), n, tree.count.data(), tree.post.data(), common) ==
             all;
}

} // namespace

cholmod_factor* symbolic_factor(const SparseMatrix& k, const ContactLastOrder& order,
                                CholmodSession& session) {
  cholmod_common* common = session.common();
  const std::size_t n = order.permutation.size();
  Tree tree;
  if (!find_tree(k, order, common, tree)) return nullptr;
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
  auto final_triangle = triangle(k, order, {permutation, n}, true);
  cholmod_sparse upper = final_triangle.view(1);
  if (cholmod_l_super_symbolic2(CHOLMOD_ANALYZE_FOR_CHOLESKY, &upper, nullptr, parent.data(), l,
                                common) == 0)
    cholmod_l_free_factor(&l, common);
  return l;
}

} // namespace hvi::solver
