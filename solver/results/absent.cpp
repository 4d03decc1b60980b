// See absent.hpp.
#include "solver/results/absent.hpp"

#include "solver/kernel/expr.hpp"
#include "solver/kernel/slot.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace hvi::solver {
namespace {

/// Which unknowns with a domain of their own it reads; none where it tells parts apart.
std::set<int> confined_unknowns(const Space& space, const FieldSpec& field) {
  std::set<int> out;
  for (const Expr& e : field.components) {
    if (e.depends_on_any(slot::first_inside, slot::first_state)) return {};
    for (const Slot s : slots_of(e))
      if (slot::is_field(s)) out.insert(slot::unknown_of(slot::derivative_of(s)));
  }
  std::erase_if(out, [&](int unknown) {
    return space.blocks[static_cast<std::size_t>(unknown)].domain == nullptr;
  });
  return out;
}

} // namespace

void forget_where_absent(const Space& space, const FieldSpec& field, bool on_cells,
                         std::span<double> values) {
  const std::set<int> unknowns = confined_unknowns(space, field);
  if (unknowns.empty()) return;
  const auto cells = static_cast<int>(space.mesh->cells.size());
  std::vector<char> known(on_cells ? space.mesh->cells.size() : space.nodes.size(), 0);
  for (int cell = 0; cell < cells; ++cell) {
    const bool lives = std::ranges::all_of(unknowns, [&](int unknown) {
      return space.blocks[static_cast<std::size_t>(unknown)].lives_in(cell);
    });
    if (!lives) continue;
    if (on_cells)
      known[static_cast<std::size_t>(cell)] = 1;
    else
      for (const auto node : space.nodes_of_cell(cell)) known[static_cast<std::size_t>(node)] = 1;
  }
  const std::size_t n = field.components.size();
  for (std::size_t k = 0; k < values.size(); ++k)
    if (known[k / n] == 0) values[k] = std::nan("");
}

} // namespace hvi::solver
