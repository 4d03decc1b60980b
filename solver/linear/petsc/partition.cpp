// See partition.hpp.
#include "solver/linear/petsc/partition.hpp"

#include "solver/linear/petsc/session.hpp"

#include <algorithm>
#include <numeric>

namespace hvi::petsc_module {
namespace {

/// Fewer nodes than this for each process are not worth a search.
constexpr int few_nodes = 8;

/// Nodes that share an entry of K, both ways and each once.
struct Graph {
  std::vector<int> start{0}, neighbour;
};

Graph graph_of(const HviPetscMatrix& k, const HviPetscUnknowns& unknowns) {
  std::vector<std::vector<int>> of(static_cast<std::size_t>(unknowns.nodes));
  for (int i = 0; i < k.rows; ++i)
    for (int e = k.start[i]; e < k.start[i + 1]; ++e) {
      const int a = unknowns.node[i], b = unknowns.node[k.column[e]];
      if (a == b || unknowns.component[k.column[e]] != 0) continue;
      of[a].push_back(b);
      of[b].push_back(a);
    }
  Graph out;
  for (std::vector<int>& nodes : of) {
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    out.neighbour.insert(out.neighbour.end(), nodes.begin(), nodes.end());
    out.start.push_back(static_cast<int>(out.neighbour.size()));
    nodes = {};
  }
  return out;
}

/// PETSc frees it.
PetscInt* given_away(const std::vector<int>& values) {
  PetscInt* out = nullptr;
  check(PetscMalloc1(values.size() + 1, &out));
  std::copy(values.begin(), values.end(), out);
  return out;
}

std::vector<int> parts_by_scotch(const Graph& graph, int parts) {
  const PetscInt nodes = static_cast<PetscInt>(graph.start.size()) - 1;
  Owned<Mat> edges;
  Owned<MatPartitioning> search;
  Owned<IS> found;
  check(MatCreateMPIAdj(PETSC_COMM_SELF, nodes, nodes, given_away(graph.start),
                        given_away(graph.neighbour), nullptr, edges.put()));
  check(MatPartitioningCreate(PETSC_COMM_SELF, search.put()));
  check(MatPartitioningSetAdjacency(search.get(), edges.get()));
  check(MatPartitioningSetType(search.get(), MATPARTITIONINGPTSCOTCH));
  check(MatPartitioningSetNParts(search.get(), parts));
  check(MatPartitioningApply(search.get(), found.put()));
  const PetscInt* part = nullptr;
  check(ISGetIndices(found.get(), &part));
  std::vector<int> out(part, part + nodes);
  check(ISRestoreIndices(found.get(), &part));
  return out;
}

std::vector<int> parts_in_order(int nodes, int parts) {
  std::vector<int> out(static_cast<std::size_t>(nodes));
  for (int i = 0; i < nodes; ++i)
    out[i] = static_cast<int>(static_cast<long long>(i) * parts / nodes);
  return out;
}

} // namespace

Partition partition_of(const HviPetscMatrix& k, const HviPetscUnknowns& unknowns, int parts) {
  const int nodes = unknowns.nodes;
  if (parts == 1 || nodes == 0) return {{}, {nodes}};
  const std::vector<int> part = nodes < few_nodes * parts
                                    ? parts_in_order(nodes, parts)
                                    : parts_by_scotch(graph_of(k, unknowns), parts);
  Partition out;
  out.counts.assign(static_cast<std::size_t>(parts), 0);
  for (const int p : part) ++out.counts[p];
  std::vector<int> next(out.counts.size(), 0);
  std::partial_sum(out.counts.begin(), out.counts.end() - 1, next.begin() + 1);
  for (const int p : part) out.place.push_back(next[p]++);
  return out;
}

} // namespace hvi::petsc_module
