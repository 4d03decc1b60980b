// See ordering.hpp.
#include "solver/linear/ordering.hpp"

#include "solver/common/clock.hpp"
#include "solver/common/failure.hpp"
#include "solver/common/metis_turn.hpp"
#include "solver/common/out_of_memory.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

namespace hvi::solver {
namespace {

/// Measured: in 2D constrained CAMD is within 2 % of METIS at a tenth of its time; in 3D
/// METIS saves 20 to 50 % of the work. The work per unknown with CAMD tells 2D from 3D.
constexpr double flops_per_unknown_for_metis = 1e5;

[[noreturn]] void refuse_without_memory(const VertexGraph& graph) {
  throw OutOfMemory("no memory to order a matrix of {} unknowns", graph.first.back());
}
/// Falling back to another ordering would give other bits.
void refuse_without_memory(const VertexGraph& graph, const cholmod_common& common) {
  if (common.status == CHOLMOD_OUT_OF_MEMORY) refuse_without_memory(graph);
}

bool joined(const VertexGraph& graph, Long a, Long b) {
  return std::ranges::binary_search(graph.neighbours(a), b);
}

/// Chains the contact vertices: (c_i, c_i+1) for all i where there is no edge.
Links chain(const VertexGraph& graph) {
  Links links;
  const auto& contact = graph.contact;
  for (std::size_t i = 0; i + 1 < contact.size(); ++i)
    if (!joined(graph, contact[i], contact[i + 1])) links.emplace_back(contact[i], contact[i + 1]);
  return links;
}

/// Joins the last eliminated vertex of each component of the interior to the first contact one:
/// otherwise its subtree may hang on a later contact vertex, and be postordered behind the first.
void join_components(const VertexGraph& graph, std::span<const Long> order, Links& links) {
  if (graph.contact.empty()) return;
  std::vector<Long> seen = graph.member, stack;
  for (auto root = order.rbegin(); root != order.rend(); ++root) {
    if (std::exchange(seen[*root], 1) != 0) continue;
    if (!joined(graph, *root, graph.contact.front()))
      links.emplace_back(*root, graph.contact.front());
    for (stack.push_back(*root); !stack.empty();) {
      const Long vertex = stack.back();
      stack.pop_back();
      for (const Long other : graph.neighbours(vertex))
        if (std::exchange(seen[other], 1) == 0) stack.push_back(other);
    }
  }
}

/// The interior's order by CAMD (approximate minimum degree with constraints: P. R. Amestoy,
/// T. A. Davis, I. S. Duff, An approximate minimum degree ordering algorithm, SIAM J. Matrix Anal.
/// Appl. 17 (1996) 886-905) with two constraint sets, interior before contact. `flops`: roughly
/// those of a factorisation of K.
std::optional<std::vector<Long>> camd_order(VertexGraph& graph, cholmod_common* common,
                                            double& flops) {
  flops = 0.0;
  // CAMD reads past its buckets when the first set is empty: then nothing is left to order.
  if (std::ranges::find(graph.member, 0) == graph.member.end()) return std::vector<Long>{};
  std::vector<Long> order(graph.member.size());
  cholmod_sparse view = graph.edges.view(1);
  auto member = graph.member;
  if (cholmod_l_camd(&view, nullptr, 0, member.data(), order.data(), common) == 0) {
    refuse_without_memory(graph, *common);
    return {};
  }
  // CAMD leaves an upper bound, of the graph: each of its operations is one on blocks.
  const double block = static_cast<double>(graph.first.back()) / graph.size();
  flops = common->fl * block * block * block;
  std::erase_if(order, [&](Long vertex) { return graph.member[vertex] != 0; });
  return order;
}

/// METIS's nested dissection of the interior's graph (G. Karypis, V. Kumar, A fast and high quality
/// multilevel scheme for partitioning irregular graphs, SIAM J. Sci. Comput. 20 (1998) 359-392).
std::optional<std::vector<Long>> metis_order(const VertexGraph& graph, cholmod_common* common) {
  Pattern interior;
  std::vector<Long> vertex, local(graph.member.size(), -1);
  for (int v = 0; v < graph.size(); ++v) {
    if (graph.member[v] != 0) continue;
    local[v] = static_cast<Long>(vertex.size());
    vertex.push_back(v);
    for (const Long other : graph.neighbours(v))
      if (other <= v && local[other] >= 0) interior.row.push_back(local[other]);
    interior.start.push_back(static_cast<Long>(interior.row.size()));
  }
  cholmod_sparse view = interior.view(1);
  std::vector<Long> order(vertex.size());
  const std::scoped_lock lock(metis_turn());
  if (cholmod_l_metis(&view, nullptr, 0, 0, order.data(), common) == 0) {
    refuse_without_memory(graph, *common);
    return {};
  }
  // CHOLMOD does not report that METIS had no memory; the order is then no permutation.
  std::vector<char> seen(order.size(), 0);
  for (Long& position : order) {
    if (position < 0 || position >= static_cast<Long>(seen.size()) || seen[position]++ != 0)
      refuse_without_memory(graph);
    position = vertex[position];
  }
  return order;
}

/// The interior's order with the contact vertices behind it.
std::vector<Long> whole(const VertexGraph& graph, std::vector<Long> interior) {
  interior.insert(interior.end(), graph.contact.begin(), graph.contact.end());
  return interior;
}

/// Rows and columns of `order`'s upper triangle, unknowns by position.
Pattern above_diagonal(const VertexGraph& graph, const Links& links, std::span<const Long> order) {
  std::vector<Long> place(order.size()), at(order.size());
  Long unknowns = 0;
  for (std::size_t j = 0; j < order.size(); ++j) {
    place[order[j]] = static_cast<Long>(j);
    at[order[j]] = std::exchange(unknowns, unknowns + graph.unknowns_of(order[j]));
  }
  Links upper; // (later, earlier) place
  for (const auto& [a, b] : links)
    upper.emplace_back(std::max(place[a], place[b]), std::min(place[a], place[b]));
  std::ranges::sort(upper);
  auto next = upper.begin();
  Pattern out;
  out.start.reserve(static_cast<std::size_t>(unknowns) + 1);
  out.row.reserve(graph.edges.row.size() * static_cast<std::size_t>(unknowns) / order.size());
  for (Long j = 0; j < static_cast<Long>(order.size()); ++j) {
    const auto begin = static_cast<std::ptrdiff_t>(out.row.size());
    for (const Long other : graph.neighbours(order[j]))
      if (place[other] <= j) out.row.push_back(at[other]);
    for (; next != upper.end() && next->first == j; ++next)
      out.row.push_back(at[order[next->second]]);
    const auto end = static_cast<std::ptrdiff_t>(out.row.size());
    out.start.push_back(end);
    for (int k = 1; k < graph.unknowns_of(order[j]); ++k) { // the vertex's other unknowns
      for (auto e = begin; e < end; ++e) out.row.push_back(Long{out.row[e]});
      out.start.push_back(static_cast<Long>(out.row.size()));
    }
  }
  return out;
}

/// From vertices to unknowns, postordered.
ContactLastOrder of_unknowns(const VertexGraph& graph, const Links& links,
                             std::span<const Long> order, const EliminationTree& tree) {
  std::vector<Long> vertices, first(order.size()); // first: unknown's position, by place in `order`
  vertices.reserve(order.size());
  Long unknowns = 0;
  for (const Long place : tree.post) {
    vertices.push_back(order[place]);
    first[place] = std::exchange(unknowns, unknowns + graph.unknowns_of(order[place]));
  }
  ContactLastOrder out;
  for (auto* column : {&out.permutation, &out.parent, &out.count})
    column->reserve(static_cast<std::size_t>(unknowns));
  for (const Long place : tree.post) {
    const Long vertex = order[place], above = tree.parent[place];
    const int last = graph.unknowns_of(vertex) - 1;
    for (int k = 0; k <= last; ++k) {
      out.permutation.push_back(graph.first[vertex] + k);
      out.count.push_back(tree.count[place] - k);
      if (k < last)
        out.parent.push_back(first[place] + k + 1);
      else
        out.parent.push_back(above < 0 ? -1 : first[above]);
    }
  }
  out.above = above_diagonal(graph, links, vertices);
  out.nonzeros = tree.nonzeros;
  out.flops = tree.flops;
  return out;
}

} // namespace

EliminationOrder elimination_order(const ContactLastOrder& order, std::span<const int> contact) {
  EliminationOrder out{{order.permutation.begin(), order.permutation.end()}, 0};
  out.interior = out.size() - static_cast<int>(contact.size());
  if (!std::equal(contact.begin(), contact.end(), out.unknown.begin() + out.interior))
    throw std::logic_error("the postorder moved a contact unknown from the end of the elimination");
  return out;
}

ContactLastOrder OrderStore::order(const SparseMatrix& k, std::span<const int> contact,
                                   CholmodSession& session) {
  constexpr std::size_t most = 4;
  const auto equal = [](const std::vector<int>& a, const int* b, std::size_t n) {
    return a.size() == n && std::equal(a.begin(), a.end(), b);
  };
  const auto n = static_cast<std::size_t>(k.rows()) + 1, m = static_cast<std::size_t>(k.nonZeros());
  for (const Known& one : known_)
    if (equal(one.outer, k.outerIndexPtr(), n) && equal(one.inner, k.innerIndexPtr(), m) &&
        equal(one.contact, contact.data(), contact.size())) {
      ++reused_;
      seconds_spared_ += one.seconds;
      seconds_of_last_ = one.seconds;
      return one.order;
    }
  const double start = cpu_seconds();
  auto found = order_contact_last(k, contact, session);
  const double seconds = cpu_seconds() - start;
  if (known_.size() == most) known_.erase(known_.begin());
  known_.push_back({{k.outerIndexPtr(), k.outerIndexPtr() + n},
                    {k.innerIndexPtr(), k.innerIndexPtr() + m},
                    {contact.begin(), contact.end()},
                    found,
                    seconds});
  seconds_of_last_ = 0;
  return found;
}

ContactLastOrder order_contact_last(const SparseMatrix& k, std::span<const int> contact,
                                    CholmodSession& session) {
  auto graph = vertex_graph(k, contact);
  double flops = 0.0;
  const auto interior = camd_order(graph, session.common(), flops);
  if (!interior) throw Failure(FailureKind::limit, {}, "the matrix is too large to order");
  auto links = chain(graph);
  auto order = whole(graph, *interior);
  std::string name = "CAMD";
  if (flops > flops_per_unknown_for_metis * static_cast<double>(k.rows()))
    if (const auto dissected = metis_order(graph, session.common())) {
      auto other = whole(graph, *dissected);
      if (elimination_tree(graph, links, other, session).nonzeros <
          elimination_tree(graph, links, order, session).nonzeros)
        order = std::move(other), name = "METIS";
    }
  join_components(graph, order, links);
  auto out = of_unknowns(graph, links, order, elimination_tree(graph, links, order, session));
  out.name = std::move(name);
  return out;
}

} // namespace hvi::solver
