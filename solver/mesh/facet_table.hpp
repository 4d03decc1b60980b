// All facets of all cells, sorted so that the sides of one facet stand together. Internal to
// solver/mesh: build_facets, refine and pieces_of are written with it.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

/// Nodes of local facet `local` (opposite to node `local`) of a cell, ordered outwards.
std::array<std::int32_t, 3> local_facet(int dim, const std::array<std::int32_t, 4>& cell,
                                        int local);

/// The order of nodes that a facet has from its other side. That of a point is one whatever its
/// side.
void turn(int dim, std::array<std::int32_t, 3>& nodes);

/// A facet's nodes sorted, and whether sorting them was an odd permutation.
struct FacetKey {
  std::array<std::int32_t, 3> nodes{-1, -1, -1};
  bool odd = false;
};
FacetKey facet_key(int dim, std::array<std::int32_t, 3> nodes);

class FacetTable {
public:
  /// One side of a facet. Its smallest node is the bucket it is in.
  struct Side {
    std::int32_t second, third; ///< the other sorted nodes, -1 where there are none
    std::int32_t cell;
    std::int8_t local;
    bool odd; ///< orientation of the outward order; the two sides of a facet differ in it
  };

  /// With `among` (a flag for each node) of the facets between flagged nodes only.
  explicit FacetTable(const Mesh& mesh, std::span<const char> among = {});

  const std::vector<Side>& sides() const { return sides_; }
  /// The sides begin .. end of one facet.
  struct Run {
    std::size_t begin, end;
  };
  /// The run of a facet; empty if no cell has it.
  Run find(const FacetKey& key) const;
  /// Calls f(run) for every facet, ordered by its sorted nodes.
  template <typename F>
  void for_each(F&& f) const {
    for (std::size_t n = 0; n + 1 < first_.size(); ++n) {
      for (std::size_t begin = first_[n]; begin < first_[n + 1];) {
        const Run run{begin, run_end(begin, first_[n + 1])};
        f(run);
        begin = run.end;
      }
    }
  }

private:
  std::size_t run_end(std::size_t begin, std::size_t bucket_end) const;

  std::vector<std::uint32_t> first_; ///< bucket of node i: sides first_[i] .. first_[i + 1]
  std::vector<Side> sides_;
};

/// build_facets with index -1 for a named facet that no cell has. With `among` (a flag for each
/// node) all facets to be found are known to lie between flagged nodes.
std::vector<std::int32_t> index_facets(Mesh& mesh,
                                       const std::vector<std::array<std::int32_t, 3>>& named,
                                       std::span<const char> among = {});

} // namespace hvi::solver
