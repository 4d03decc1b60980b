// A tree of boxes that is asked which of them meet a box. Internal to solver/mesh.
#pragma once

#include "solver/mesh/mesh.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace hvi::solver {

/// The smallest box around both.
void include(Box& box, const Box& other);
/// That of a cell.
Box box_of(const Mesh& mesh, std::int32_t cell);
inline bool meet(const Box& a, const Box& b) {
  for (int i = 0; i < 3; ++i)
    if (a.high[i] < b.low[i] || b.high[i] < a.low[i]) return false;
  return true;
}

/// Halved at the median centre: O(log n) and what is found for a look-up.
class BoxTree {
public:
  explicit BoxTree(std::vector<Box> boxes);
  /// Calls visit(i) for every box i that meets `box`.
  template <class Visit>
  void for_each_meeting(const Box& box, const Visit& visit) const {
    std::array<std::int32_t, 64> stack; // the tree is balanced: depth below 32
    int top = 0;
    if (!nodes_.empty()) stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (!meet(node.box, box)) continue;
      if (node.count == 0) {
        stack[top++] = node.first;
        stack[top++] = node.first + 1;
        continue;
      }
      for (auto i = node.first; i < node.first + node.count; ++i)
        if (meet(boxes_[order_[i]], box)) visit(order_[i]);
    }
  }

private:
  struct Node {
    Box box;
    std::int32_t first = 0, count = 0; ///< leaf: boxes order_[first ...]; else count 0, child first
  };
  void build(std::int32_t node, std::int32_t first, std::int32_t past);

  std::vector<Box> boxes_;
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
};

} // namespace hvi::solver
