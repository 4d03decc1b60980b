// See fields_read.hpp.
#include "solver/discrete/fields_read.hpp"

#include <algorithm>

namespace hvi::solver {

std::vector<bool> fields_read(std::span<const Expr> expressions, int n_fields) {
  std::vector<bool> out(n_fields, false);
  for (const auto& expression : expressions)
    for (int k = 0; k < n_fields; ++k)
      if (expression.depends_on_any(slot::field(k, 0), slot::field(k + 1, 0))) out[k] = true;
  return out;
}

bool reads_multiplier(const Expr& expression) {
  return expression.depends_on_any(slot::first_multiplier, slot::first_inside) ||
         expression.depends_on_any(slot::first_state, slot::first_probe);
}

bool reads_gradient(const Expr& expression, int n_fields) {
  return std::ranges::any_of(expression.slots(), [&](Slot s) {
    return slot::is_field_gradient(s) && slot::field_of(s) < n_fields;
  });
}

} // namespace hvi::solver
