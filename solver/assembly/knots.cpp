#include "solver/assembly/knots.hpp"

#include "solver/kernel/table.hpp"

#include <algorithm>
#include <utility>

namespace hvi::solver {

namespace {

/// Where argument = value, if the argument is a t + b.
void add_crossing(const Expr& argument, double value, Knots& knots) {
  const Expr slope = derivative(argument, slot::t);
  const std::pair<Slot, Expr> at_zero{slot::t, Expr(0.0)};
  const Expr offset = substitute(argument, {&at_zero, 1});
  if (slope.is_constant() && !slope.is(0.0) && offset.is_constant())
    knots.times.push_back((value - offset.value()) / slope.value());
  else if (std::ranges::all_of(argument.slots(), [](Slot s) { return s == slot::t; }))
    knots.signs.push_back(argument - value);
}

} // namespace

void collect_knots(const Expr& expression, Knots& knots) {
  if (!expression.depends_on(slot::t)) {
    return;
  }
  for (const Expr& arg : expression.args()) {
    collect_knots(arg, knots);
  }
  const auto& args = expression.args();
  switch (expression.op()) {
  case Op::table:
  case Op::table_slope:
    for (const double knot : expression.table()->abscissae()) {
      add_crossing(args[0], knot, knots);
    }
    return;
  case Op::less:
  case Op::less_equal:
  case Op::equal:
  case Op::min:
  case Op::max:
    return add_crossing(args[0] - args[1], 0.0, knots);
  case Op::abs:
  case Op::sign:
    return add_crossing(args[0], 0.0, knots);
  default:
    return;
  }
}

} // namespace hvi::solver
