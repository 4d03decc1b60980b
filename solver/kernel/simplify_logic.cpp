// Simplification of everything that is not a sum or a product: kinks, comparisons, logic, cases.
#include "solver/kernel/node.hpp"
#include "solver/kernel/simplify.hpp"

#include <cmath>

namespace hvi::solver::rules {

namespace {

/// True when a stands before b in a commutative operation. Any total order would do; this one
/// keeps long sums left-nested and prints polynomials from the highest power down.
bool before(const Expr& a, const Expr& b) {
  const auto ha = ExprAccess::height(a), hb = ExprAccess::height(b);
  if (ha != hb) return ha > hb;
  if (a.op() != b.op()) return a.op() < b.op();
  if (a.op() == Op::slot) return a.slot() < b.slot();
  return a.hash() < b.hash();
}

bool same(const Expr& a, const Expr& b) { return a.hash() == b.hash() && a == b; }

Expr negated_condition(const Expr& a) {
  if (a.op() == Op::logic_not && is_boolean(a.args()[0])) return a.args()[0];
  if (a.op() == Op::less) return comparison(Op::less_equal, a.args()[1], a.args()[0]);
  if (a.op() == Op::less_equal) return comparison(Op::less, a.args()[1], a.args()[0]);
  return ExprAccess::raw(Op::logic_not, {a});
}

Expr absolute(const Expr& a) {
  switch (a.op()) {
  case Op::abs:
  case Op::exp:
  case Op::sqrt:
    return a;
  case Op::neg:
    return absolute(a.args()[0]);
  case Op::mul:
    if (a.args()[0].is_constant())
      return product(std::abs(a.args()[0].value()), absolute(a.args()[1]));
    break;
  case Op::pow:
    if (a.args()[1].is_constant() && std::fmod(a.args()[1].value(), 2.0) == 0.0) return a;
    break;
  default:
    break;
  }
  return ExprAccess::raw(Op::abs, {a});
}

} // namespace

Expr ordered(Op op, const Expr& a, const Expr& b, bool constant_first) {
  bool swap = before(b, a);
  if (a.is_constant() != b.is_constant()) swap = a.is_constant() != constant_first;
  return swap ? ExprAccess::raw(op, {b, a}) : ExprAccess::raw(op, {a, b});
}

Expr function(Op op, const Expr& a) {
  if (op == Op::logic_not) return negated_condition(a);
  if (op == Op::abs) return absolute(a);
  if (op == Op::sqrt && a.op() == Op::pow && a.args()[1].is(2.0)) return absolute(a.args()[0]);
  if (op == Op::log && a.op() == Op::exp) return a.args()[0];
  return ExprAccess::raw(op, {a});
}

Expr extremum(Op op, const Expr& a, const Expr& b) { return same(a, b) ? a : ordered(op, a, b); }

Expr comparison(Op op, const Expr& a, const Expr& b) {
  if (same(a, b)) return op == Op::less ? 0.0 : 1.0;
  if (op == Op::equal) return ordered(op, a, b);
  return ExprAccess::raw(op, {a, b});
}

Expr conjunction(Op op, const Expr& a, const Expr& b) {
  if (same(a, b) && is_boolean(a)) return a;
  for (const auto& [number, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    if (!number->is_constant() || std::isnan(number->value())) continue;
    const bool yes = number->value() != 0.0;
    if (yes == (op == Op::logic_or)) return yes ? 1.0 : 0.0;
    if (is_boolean(*other)) return *other;
  }
  return ordered(op, a, b);
}

Expr selection(const Expr& condition, const Expr& then, const Expr& otherwise) {
  if (condition.is_constant() && !std::isnan(condition.value()))
    return condition.value() != 0.0 ? then : otherwise;
  if (same(then, otherwise)) return then;
  if (condition.op() == Op::logic_not) return selection(condition.args()[0], otherwise, then);
  // Derivatives of nested cases ask the same question twice.
  if (then.op() == Op::select && same(then.args()[0], condition))
    return selection(condition, then.args()[1], otherwise);
  if (otherwise.op() == Op::select && same(otherwise.args()[0], condition))
    return selection(condition, then, otherwise.args()[2]);
  return ExprAccess::raw(Op::select, {condition, then, otherwise});
}

} // namespace hvi::solver::rules
