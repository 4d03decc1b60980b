// See nodes_of_unknowns.hpp.
#include "solver/discrete/nodes_of_unknowns.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

/// Adds the motions of one of the unknowns: translations, or constants, and turns of vectors in
/// their own space, about the middle of the nodes. Whatever the values imposed and the pieces:
/// parts of the mesh move so at little cost.
void add_motions(const Space& space, const SpaceBlock& block, const StateLayout& layout,
                 DenseMatrix& out) {
  const int components = block.components;
  const bool turns = components > 1 && components == space.mesh->dim;
  const int n_turns = !turns ? 0 : components == 2 ? 1 : 3;
  Point low = space.nodes.front(), high = low;
  for (const Point& x : space.nodes)
    for (std::size_t a = 0; a < 3; ++a)
      low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
  double size = 0.0;
  for (std::size_t a = 0; a < 3; ++a) size = std::max(size, high[a] - low[a]);
  const auto before = out.cols();
  out.conservativeResizeLike(DenseMatrix::Zero(layout.n_unknowns, before + components + n_turns));
  for (int i = 0; i < layout.n_unknowns; ++i) {
    const auto dof = layout.dof_of[static_cast<std::size_t>(i)];
    const int c = dof % space.components - block.first;
    if (c < 0 || c >= components) continue;
    const Point& x = space.nodes[static_cast<std::size_t>(dof / space.components)];
    const auto arm = [&](int a) {
      const auto k = static_cast<std::size_t>(a);
      return (x[k] - 0.5 * (low[k] + high[k])) / size;
    };
    auto motion = out.row(i).segment(before, components + n_turns);
    motion[c] = 1.0;
    if (n_turns == 1) motion[2] = c == 0 ? -arm(1) : arm(0);
    if (n_turns == 3) { // axis x arm
      motion[3 + (c + 1) % 3] = arm((c + 2) % 3);
      motion[3 + (c + 2) % 3] = -arm((c + 1) % 3);
    }
  }
}

} // namespace

std::shared_ptr<UnknownsOfNodes> nodes_of_unknowns(const Discretisation& d,
                                                   const StateLayout& layout) {
  auto out = std::make_shared<UnknownsOfNodes>();
  const int components = d.space.components;
  out->components = components;
  std::vector<std::int32_t> number(d.space.nodes.size(), -1);
  for (int i = 0; i < layout.n_unknowns; ++i) {
    const auto dof = layout.dof_of[static_cast<std::size_t>(i)];
    auto& of_node = number[static_cast<std::size_t>(dof / components)];
    if (of_node < 0) of_node = out->nodes++;
    out->node.push_back(of_node);
    out->component.push_back(dof % components);
  }
  out->first_component.clear();
  for (const SpaceBlock& block : d.space.blocks) {
    out->first_component.push_back(block.first);
    add_motions(d.space, block, layout, out->motions);
  }
  return out;
}

} // namespace hvi::solver
