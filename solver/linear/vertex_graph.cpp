// See vertex_graph.hpp.
#include "solver/linear/vertex_graph.hpp"

#include <algorithm>

namespace hvi::solver {
namespace {

/// Vertices of K's unknowns, without edges; `vertex_of` each unknown.
VertexGraph vertices(const SparseMatrix& k, std::span<const int> contact,
                     std::vector<int>& vertex_of) {
  const int n = static_cast<int>(k.rows());
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  constexpr int interior = -1;
  std::vector<int> place(static_cast<std::size_t>(n), interior);
  for (std::size_t c = 0; c < contact.size(); ++c) place[contact[c]] = static_cast<int>(c);
  const auto goes_with_last = [&](int i) {
    if (i == 0 || (place[i] == interior) != (place[i - 1] == interior)) return false;
    if (place[i] != interior && place[i] != place[i - 1] + 1) return false;
    const int length = outer[i + 1] - outer[i];
    return length == outer[i] - outer[i - 1] &&
           std::equal(inner + outer[i], inner + outer[i + 1], inner + outer[i - 1]);
  };
  VertexGraph graph;
  vertex_of.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    if (!goes_with_last(i)) {
      graph.first.push_back(i);
      graph.member.push_back(place[i] != interior);
    }
    vertex_of[i] = graph.size() - 1;
  }
  graph.first.push_back(n);
  for (const int unknown : contact)
    if (const Long v = vertex_of[unknown]; graph.first[v] == unknown) graph.contact.push_back(v);
  return graph;
}

} // namespace

VertexGraph vertex_graph(const SparseMatrix& k, std::span<const int> contact) {
  std::vector<int> vertex_of;
  VertexGraph graph = vertices(k, contact, vertex_of);
  const int* outer = k.outerIndexPtr();
  const int* inner = k.innerIndexPtr();
  std::size_t entries = 0; // at most: the rows of the vertices' first unknowns
  for (int v = 0; v < graph.size(); ++v)
    entries += outer[graph.first[v] + 1] - outer[graph.first[v]];
  auto& [start, row] = graph.edges;
  start.reserve(graph.member.size() + 1);
  row.reserve(entries);
  for (int v = 0; v < graph.size(); ++v) {
    int last = -1;
    for (int at = outer[graph.first[v]]; at < outer[graph.first[v] + 1]; ++at)
      if (const int other = vertex_of[inner[at]]; other != last) row.push_back(last = other);
    start.push_back(static_cast<Long>(row.size()));
  }
  return graph;
}

} // namespace hvi::solver
