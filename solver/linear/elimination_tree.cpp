// See elimination_tree.hpp.
#include "solver/linear/elimination_tree.hpp"

#include "solver/common/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace hvi::solver {
namespace {

/// Links by position: (column, row) of one triangle, sorted.
std::vector<std::pair<Long, Long>> placed(Links links, std::span<const Long> position, bool upper) {
  std::vector<std::pair<Long, Long>> out;
  for (const auto& [a, b] : links) {
    const auto [low, high] = std::minmax(position[a], position[b]);
    out.emplace_back(upper ? high : low, upper ? low : high);
  }
  std::ranges::sort(out);
  return out;
}

} // namespace

cholmod_sparse Triangle::view(int stype) {
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

/// Row u of K holds, by symmetry, column u: both triangles are there to be picked.
Triangle triangle(const SparseMatrix& k, Links links, std::span<const Long> permutation,
                  bool upper) {
  const auto n = static_cast<Long>(permutation.size());
  std::vector<Long> position(permutation.size());
  for (Long j = 0; j < n; ++j) position[permutation[j]] = j;
  const auto added = placed(links, position, upper);
  auto next = added.begin();
  Triangle out;
  out.start.reserve(permutation.size() + 1);
  out.row.reserve((static_cast<std::size_t>(k.nonZeros()) + permutation.size()) / 2 + added.size());
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  for (Long j = 0; j < n; ++j) {
    const Long unknown = permutation[j];
    for (int at = outer[unknown]; at < outer[unknown + 1]; ++at)
      if (const Long i = position[inner[at]]; upper ? i <= j : i >= j) out.row.push_back(i);
    for (; next != added.end() && next->first == j; ++next) out.row.push_back(next->second);
    out.start.push_back(static_cast<Long>(out.row.size()));
  }
  return out;
}

EliminationTree elimination_tree(const SparseMatrix& k, Links links,
                                 std::span<const Long> permutation, CholmodSession& session) {
  cholmod_common* common = session.common();
  const std::size_t n = permutation.size();
  const auto all = static_cast<Long>(n);
  const auto demand = [n](bool done) {
    if (!done)
      throw Failure(FailureKind::limit, {},
                    fmt::format("no memory to analyse a matrix of {} unknowns", n));
  };
  EliminationTree tree;
  tree.parent.resize(n), tree.post.resize(n), tree.count.resize(n);
  std::size_t entries = 0;
  {
    auto above = triangle(k, links, permutation, true);
    entries = above.row.size();
    cholmod_sparse upper = above.view(1);
    demand(cholmod_l_etree(&upper, tree.parent.data(), common) != 0);
  }
  auto below = triangle(k, links, permutation, false);
  if (below.row.size() != entries)
    throw std::logic_error("the pattern of a matrix to order is not symmetric");
  cholmod_sparse lower = below.view(-1);
  std::vector<Long> first(n), level(n);
  demand(cholmod_l_postorder(tree.parent.data(), n, nullptr, tree.post.data(), common) == all);
  demand(cholmod_l_rowcolcounts(&lower, nullptr, 0, tree.parent.data(), tree.post.data(), nullptr,
                                tree.count.data(), first.data(), level.data(), common) != 0);
  demand(cholmod_l_postorder(tree.parent.data(), n, tree.count.data(), tree.post.data(), common) ==
         all);
  return tree;
}

} // namespace hvi::solver
