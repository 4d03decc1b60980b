// Local refinement by bisection: given cells are halved, and others where conformity requires it.
// Between the generated mesh and the space; called by solver/time/adapt.
//
// Every simplex has an edge at which it will be cut. Intervals and triangles: newest vertex
// bisection (W. F. Mitchell, Adaptive refinement for arbitrary finite-element spaces with
// hierarchical bases, J. Comput. Appl. Math. 36 (1991) 65-78). Tetrahedra: D. N. Arnold, A.
// Mukherjee, L. Pouly, Locally adapted tetrahedral meshes using bisection, SIAM J. Sci. Comput. 22
// (2000) 431-448: every face has a marked edge, too, and a flag tells two of the types apart. For
// any first mesh the closure ends, and the descendants of a cell have finitely many shapes, so
// angles stay bounded however often one refines.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <span>
#include <unordered_map>

namespace hvi::solver {

/// A mesh that is bisected again and again. All meshes of one object are nested.
class Bisection {
public:
  /// First cuts: the longest edges, ties by the numbers of the nodes.
  explicit Bisection(const Mesh& first);

  /// Cuts each of these cells of `mesh()` into 2^times at least, and others where a node would lie
  /// in the middle of an edge. With fewer cells the result is a coarser version of the mesh made
  /// with more. Throws Failure(limit) beyond the limit of cells.
  void bisect(std::span<const std::int32_t> cells, int times = 1);

  /// The present mesh: groups and pieces are those of the first, cells keep their number or stand
  /// at the end, of their piece where there are several.
  Mesh mesh() const;
  std::size_t n_cells() const { return cells_.size(); }

private:
  using Edge = std::array<std::int32_t, 2>; ///< nodes, the smaller first
  struct Cell {
    std::array<std::int32_t, 4> nodes;
    Edge cut{};                  ///< the edge it will be cut at
    std::array<Edge, 4> marks{}; ///< 3D: the marked edge of the face opposite each node
    bool flag = false;           ///< 3D: of a planar cell
    std::int32_t first = 0;      ///< the first cell it comes from
    int cuts = 0, due = 0;       ///< how often it was cut, and how often it shall be
  };

  std::vector<std::int32_t> in_order() const;
  Edge longest(std::span<const std::int32_t> nodes) const;
  std::int32_t midpoint(const Edge& edge);
  std::int32_t known_midpoint(const Edge& edge) const;
  bool hangs(const Cell& cell) const;
  void cut(std::int32_t cell);
  void mark_children(const Cell& parent, std::int32_t m, Cell& a, Cell& b) const;
  void pieces(const std::array<std::int32_t, 3>& facet, const Edge& cut,
              std::vector<std::array<std::int32_t, 3>>& out) const;

  Mesh first_;
  std::vector<Point> nodes_;
  std::vector<Cell> cells_;
  std::unordered_map<std::uint64_t, std::int32_t> midpoints_;
};

} // namespace hvi::solver
