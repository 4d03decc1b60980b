// What is made of a pairing: its points as a block, its rows for unknowns of lower order. See
// pairing.hpp.
#include "solver/assembly/pairing.hpp"
#include "solver/fem/element.hpp"

#include <array>
#include <cmath>

namespace hvi::solver {

PointBlock as_block(const Space& space, const Pairing& pairing) {
  PointBlock block;
  for (std::size_t p = 0; p < pairing.x.size(); ++p)
    for (std::size_t j = 0; j < 3; ++j) {
      block.x[j].push_back(pairing.x[p][j]);
      block.normal[j].push_back(pairing.normal[p][j]);
    }
  block.weight = pairing.weight;
  block.gap = pairing.gap;
  block.cell = pairing.cell;
  block.entity = pairing.facet;
  block.kind = Group::Kind::facets;
  block.indicators = space.indicators;
  return block;
}

SparseMatrix straightened(const Space& space, const SparseMatrix& jump) {
  std::vector<std::array<int, 2>> ends(space.nodes.size());
  for (std::size_t n = 0; n < ends.size(); ++n) ends[n].fill(static_cast<int>(n));
  const auto& edges = simplex_edges(space.mesh->dim - 1);
  const auto corners = static_cast<std::size_t>(space.mesh->dim);
  for (std::size_t f = 0; space.order == 2 && f < space.mesh->facets.size(); ++f) {
    const auto nodes = space.nodes_of_facet(static_cast<int>(f));
    for (std::size_t e = 0; e < edges.size(); ++e)
      ends[static_cast<std::size_t>(nodes[corners + e])] = {
          nodes[static_cast<std::size_t>(edges[e][0])],
          nodes[static_cast<std::size_t>(edges[e][1])]};
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index row = 0; row < jump.rows(); ++row)
    for (SparseMatrix::InnerIterator it(jump, row); it; ++it)
      for (const int end : ends[static_cast<std::size_t>(it.col())])
        entries.emplace_back(static_cast<int>(row), end, it.value() / 2);
  SparseMatrix out(jump.rows(), jump.cols());
  out.setFromTriplets(entries.begin(), entries.end());
  constexpr double rounding = 1e-14; // what biorthogonality leaves of other nodes of the side
  out.prune([](Eigen::Index, Eigen::Index, double v) { return std::abs(v) > rounding; });
  return out;
}

} // namespace hvi::solver
