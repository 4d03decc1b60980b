// A tree of boxes that is asked which of them meet a box.
#include "solver/mesh/box_tree.hpp"

#include <algorithm>
#include <numeric>

namespace hvi::solver {

void include(Box& box, const Box& other) {
  for (int a = 0; a < 3; ++a) {
    box.low[a] = std::min(box.low[a], other.low[a]);
    box.high[a] = std::max(box.high[a], other.high[a]);
  }
}

Box box_of(const Mesh& mesh, std::int32_t cell) {
  const auto& c = mesh.cells[cell];
  Box box{mesh.nodes[c[0]], mesh.nodes[c[0]]};
  for (int i = 1; i <= mesh.dim; ++i) include(box, {mesh.nodes[c[i]], mesh.nodes[c[i]]});
  return box;
}

BoxTree::BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  if (order_.empty()) return;
  nodes_.emplace_back();
  build(0, 0, static_cast<std::int32_t>(order_.size()));
}

void BoxTree::build(std::int32_t node, std::int32_t first, std::int32_t past) {
  constexpr std::int32_t leaf_size = 8;
  Box all = boxes_[order_[first]];
  for (auto i = first + 1; i < past; ++i) include(all, boxes_[order_[i]]);
  if (past - first <= leaf_size) {
    nodes_[node] = {all, first, past - first};
    return;
  }
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (all.high[a] - all.low[a] > all.high[axis] - all.low[axis]) axis = a;
  const auto centre = [&](std::int32_t i) { return boxes_[i].low[axis] + boxes_[i].high[axis]; };
  const auto middle = first + (past - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + past,
                   [&](std::int32_t i, std::int32_t j) { return centre(i) < centre(j); });
  const auto child = static_cast<std::int32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node] = {all, child, 0};
  build(child, first, middle);
  build(child + 1, middle, past);
}

} // namespace hvi::solver
