// See partition.hpp.
#include "solver/linear/petsc/partition.hpp"

#include "solver/linear/petsc/session.hpp"

#include <metis.h>

#include <algorithm>
#include <new>
#include <numeric>
#include <type_traits>

namespace hvi::petsc_module {
namespace {

/// Fewer nodes than this for each process are not worth a search.
constexpr int few_nodes = 8;

/// Nodes that share an entry of K.
Graph graph_of(const HviPetscMatrix& k, const HviPetscUnknowns& unknowns) {
  std::vector<std::vector<int>> of(static_cast<std::size_t>(unknowns.nodes));
  for (int i = 0; i < k.rows; ++i)
    for (int e = k.start[i]; e < k.start[i + 1]; ++e) {
      const int a = unknowns.node[i], b = unknowns.node[k.column[e]];
      if (a == b || (e > k.start[i] && unknowns.node[k.column[e - 1]] == b)) continue;
      of[a].push_back(b);
      of[b].push_back(a);
    }
  return Graph(std::move(of));
}

std::vector<int> parts_in_order(int nodes, int parts) {
  std::vector<int> out(static_cast<std::size_t>(nodes));
  for (int i = 0; i < nodes; ++i)
    out[i] = static_cast<int>(static_cast<long long>(i) * parts / nodes);
  return out;
}

} // namespace

Graph::Graph(std::vector<std::vector<int>> noted) {
  for (std::vector<int>& of : noted) {
    std::sort(of.begin(), of.end());
    of.erase(std::unique(of.begin(), of.end()), of.end());
    neighbour.insert(neighbour.end(), of.begin(), of.end());
    start.push_back(static_cast<int>(neighbour.size()));
    of = {};
  }
}

std::vector<int> parts_of(Graph graph, std::vector<int> weights, int parts) {
  static_assert(std::is_same_v<idx_t, int>);
  int vertices = graph.vertices(), constraints = 1, cut = 0;
  if (vertices < few_nodes * parts) return parts_in_order(vertices, parts);
  std::vector<int> out(static_cast<std::size_t>(vertices));
  const int answer =
      METIS_PartGraphKway(&vertices, &constraints, graph.start.data(), graph.neighbour.data(),
                          weights.empty() ? nullptr : weights.data(), nullptr, nullptr, &parts,
                          nullptr, nullptr, nullptr, &cut, out.data());
  if (answer == METIS_ERROR_MEMORY) throw std::bad_alloc();
  if (answer != METIS_OK) throw PetscFailure("METIS finds no parts of the graph of K");
  return out;
}

Partition partition_of(const HviPetscMatrix& k, const HviPetscUnknowns& unknowns, int parts) {
  const int nodes = unknowns.nodes;
  if (parts == 1 || nodes == 0) return {{}, {nodes}};
  if (unknowns.place != nullptr)
    return {{unknowns.place, unknowns.place + nodes}, {unknowns.counts, unknowns.counts + parts}};
  const std::vector<int> part = parts_of(graph_of(k, unknowns), {}, parts);
  Partition out;
  out.counts.assign(static_cast<std::size_t>(parts), 0);
  for (const int p : part) ++out.counts[p];
  std::vector<int> next(out.counts.size(), 0);
  std::partial_sum(out.counts.begin(), out.counts.end() - 1, next.begin() + 1);
  for (const int p : part) out.place.push_back(next[p]++);
  return out;
}

} // namespace hvi::petsc_module
