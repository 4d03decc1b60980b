// See elimination_tree.hpp.
#include "solver/linear/elimination_tree.hpp"

#include "solver/common/out_of_memory.hpp"

#include <stdexcept>

namespace hvi::solver {
namespace {

constexpr Long none = -1;

/// A graph with its links, seen from the positions of an order.
class Ordered {
public:
  Ordered(const VertexGraph& graph, const Links& links, std::span<const Long> order)
      : graph_(graph), order_(order), position_(order.size()) {
    for (Long j = 0; j < size(); ++j) position_[order[j]] = j;
    auto& [start, end] = linked_;
    start.assign(order.size() + 1, 0);
    for (const auto& [a, b] : links) ++start[a], ++start[b];
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    end.resize(2 * links.size());
    for (const auto& [a, b] : links) end[--start[a]] = b, end[--start[b]] = a;
  }

  Long size() const { return static_cast<Long>(order_.size()); }
  Long weight(Long position) const { return graph_.unknowns_of(order_[position]); }
  /// visit(i) for the position i of each neighbour of the one at j, and for j.
  template <class Visit>
  void neighbours(Long j, const Visit& visit) const {
    const Long vertex = order_[j];
    for (const Long other : graph_.neighbours(vertex)) visit(position_[other]);
    for (Long at = linked_.start[vertex]; at < linked_.start[vertex + 1]; ++at)
      visit(position_[linked_.row[at]]);
  }

private:
  const VertexGraph& graph_;
  std::span<const Long> order_;
  std::vector<Long> position_;
  Pattern linked_;
};

std::vector<Long> parents(const Ordered& graph) {
  const auto n = static_cast<std::size_t>(graph.size());
  std::vector<Long> parent(n, none), ancestor(n, none);
  Long before = 0, behind = 0;
  for (Long j = 0; j < graph.size(); ++j)
    graph.neighbours(j, [&](Long i) {
      before += i<j, behind += i> j;
      while (i != none && i < j) {
        const Long next = ancestor[i];
        ancestor[i] = j;
        if (next == none) parent[i] = j;
        i = next;
      }
    });
  if (before != behind) throw std::logic_error("the pattern of a matrix to order is not symmetric");
  return parent;
}

/// Of each column of the factor the weights of its rows: a row counts where its subtree of the
/// elimination tree has a leaf, and no more where two branches of it meet.
class ColumnCounts {
public:
  ColumnCounts(const Ordered& graph, std::span<const Long> parent, std::span<const Long> post)
      : graph_(graph), parent_(parent), post_(post), n_(post.size()), first_(n_, none),
        last_first_(n_, none), last_leaf_(n_, none), ancestor_(n_), count_(n_, 0) {}

  std::vector<Long> counts() {
    for (Long place = 0; place < graph_.size(); ++place) {
      Long j = post_[place];
      if (first_[j] == none) count_[j] = graph_.weight(j); // a leaf of the tree
      for (; j != none && first_[j] == none; j = parent_[j]) first_[j] = place;
    }
    for (Long j = 0; j < graph_.size(); ++j) ancestor_[j] = j;
    for (const Long j : post_) {
      if (parent_[j] != none) count_[parent_[j]] -= graph_.weight(j);
      graph_.neighbours(j, [&](Long i) { enter(i, j); });
      if (parent_[j] != none) ancestor_[j] = parent_[j];
    }
    for (const Long j : post_)
      if (parent_[j] != none) count_[parent_[j]] += count_[j];
    return std::move(count_);
  }

private:
  /// Row i has an entry in column j.
  void enter(Long i, Long j) {
    if (i <= j || first_[j] <= last_first_[i]) return; // no leaf of the subtree of row i
    last_first_[i] = first_[j];
    const Long before = std::exchange(last_leaf_[i], j);
    count_[j] += graph_.weight(i);
    if (before != none) count_[meeting(before)] -= graph_.weight(i);
  }
  /// Where the branches of two leaves of a row meet, the later one being visited.
  Long meeting(Long leaf) {
    Long top = leaf;
    while (top != ancestor_[top]) top = ancestor_[top];
    while (leaf != top) leaf = std::exchange(ancestor_[leaf], top);
    return top;
  }

  const Ordered& graph_;
  std::span<const Long> parent_, post_;
  std::size_t n_;
  std::vector<Long> first_;      ///< descendant of each, its place in the postorder
  std::vector<Long> last_first_; ///< of each row, first_ of its last leaf
  std::vector<Long> last_leaf_, ancestor_, count_;
};

} // namespace

EliminationTree elimination_tree(const VertexGraph& graph, const Links& links,
                                 std::span<const Long> order, CholmodSession& session) {
  const Ordered ordered(graph, links, order);
  EliminationTree tree;
  tree.parent = parents(ordered);
  tree.post.resize(order.size());
  const auto postorder = [&](Long* weights) {
    if (cholmod_l_postorder(tree.parent.data(), order.size(), weights, tree.post.data(),
                            session.common()) != ordered.size())
      throw OutOfMemory("no memory to analyse a matrix of {} unknowns", graph.first.back());
  };
  postorder(nullptr);
  tree.count = ColumnCounts(ordered, tree.parent, tree.post).counts();
  postorder(tree.count.data());
  for (Long j = 0; j < ordered.size(); ++j)
    for (Long k = 0; k < ordered.weight(j); ++k) {
      const auto entries = static_cast<double>(tree.count[j] - k);
      tree.nonzeros += entries;
      tree.flops += entries * entries;
    }
  return tree;
}

} // namespace hvi::solver
