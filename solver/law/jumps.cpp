// Jumps of an expression across a comparison (jumps.hpp).
#include "solver/law/jumps.hpp"

namespace hvi::solver {

namespace {

/// e with the node replaced by its value on one side: above (1) or below (-1) the zero.
Expr on_side(const Expr& e, const Expr& node, int side) {
  const double value = node.op() == Op::sign ? side : node.op() == Op::equal ? 0.0 : side < 0;
  return transform(e, [&](const Expr& part) { return part == node ? Expr(value) : part; });
}

Expr difference(const Expr& e, const Expr& node) {
  return on_side(e, node, 1) - on_side(e, node, -1);
}

Expr of_product(const Expr& e, const Expr& node) {
  const Expr &a = e.args()[0], &b = e.args()[1];
  if (!contains(b, node)) return jump_across(a, node) * b;
  if (!contains(a, node)) return a * jump_across(b, node);
  return jump_across(a, node) * on_side(b, node, 1) + on_side(a, node, -1) * jump_across(b, node);
}

} // namespace

bool may_jump(const Switch& s) {
  switch (s.node.op()) {
  case Op::less:
  case Op::less_equal:
  case Op::sign:
    return true;
  case Op::table_slope:
    return true;
  default:
    return false;
  }
}

Expr jump_across(const Expr& e, const Expr& node) {
  if (!contains(e, node)) return 0.0;
  const auto args = e.args();
  switch (e.op()) {
  case Op::add:
    return jump_across(args[0], node) + jump_across(args[1], node);
  case Op::neg:
    return -jump_across(args[0], node);
  case Op::mul:
    return of_product(e, node);
  case Op::div:
    return contains(args[1], node) ? difference(e, node) : jump_across(args[0], node) / args[1];
  case Op::select:
    if (contains(args[0], node)) return difference(e, node);
    return select(args[0], jump_across(args[1], node), jump_across(args[2], node));
  default:
    return difference(e, node);
  }
}

} // namespace hvi::solver
