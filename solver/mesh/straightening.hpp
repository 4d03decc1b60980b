// What a mesh of second order loses when its cells are read with straight edges.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <array>
#include <vector>

namespace hvi::solver {

/// Cells have straight edges here: the nodes that cells of second order have in the middle of their
/// edges are dropped. This is what that changes.
struct Straightening {
  std::size_t edges = 0;  ///< with a node in the middle
  std::size_t curved = 0; ///< of them with that node elsewhere, by more than rounding
  double offset = 0.0;    ///< the largest distance of such a node from the middle of its edge
  Point at{};             ///< that node
  double relative = 0.0;  ///< the largest such distance over the length of the edge
  double gain = 0.0;      ///< measure of the straight cells less that of the curved ones
};

/// Adds up the cells of a mesh, each once.
class StraighteningSum {
public:
  /// Middles in gmsh's order (reference manual, "Node ordering"), with their indices among all
  /// nodes: an edge between cells counts once.
  struct Cell {
    std::array<Point, 4> corners{};
    std::array<Point, 6> middles{};
    std::array<std::int32_t, 6> indices{};
  };
  StraighteningSum(int dim, std::size_t nodes) : dim_(dim), seen_(nodes, false) {}
  void add(const Cell& cell);
  Straightening result() const { return sum_; }

private:
  int dim_;
  std::vector<bool> seen_;
  Straightening sum_;
};

} // namespace hvi::solver
