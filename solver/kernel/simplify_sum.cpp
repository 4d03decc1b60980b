// Simplification of sums: like terms within reach are collected, so that 2 u - u is u and B - B is
// 0.
#include "solver/kernel/node.hpp"
#include "solver/kernel/simplify.hpp"

#include <cmath>

namespace hvi::solver::rules {

namespace {

/// How many terms of each operand are looked at. A bound keeps long sums linear to build.
constexpr std::size_t window = 12;

/// The terms of a nested sum, left to right, at most `window` of them: what lies deeper stays one
/// opaque term. Signs are pushed into the coefficients.
std::vector<Term> terms_of(const Expr& e) {
  std::vector<Term> terms;
  std::vector<std::pair<const Expr*, double>> stack{{&e, 1.0}};
  while (!stack.empty()) {
    auto [at, sign] = stack.back();
    stack.pop_back();
    if (at->op() == Op::neg && at->args()[0].op() == Op::add) {
      at = &at->args()[0];
      sign = -sign;
    }
    if (at->op() == Op::add && terms.size() + stack.size() + 2 <= window) {
      stack.emplace_back(&at->args()[1], sign);
      stack.emplace_back(&at->args()[0], sign);
    } else {
      Term term = split_coefficient(*at);
      term.coefficient *= sign;
      terms.push_back(term);
    }
  }
  return terms;
}

bool same_base(const Term& a, const Term& b) {
  if (!a.base || !b.base) return a.base == b.base;
  return a.base->hash() == b.base->hash() && *a.base == *b.base;
}

/// Adds b's terms to a's where the base is the same and marks them by a zero coefficient.
bool merge(std::vector<Term>& a, std::vector<Term>& b) {
  bool merged = false;
  for (Term& from : b)
    for (Term& into : a) {
      const double c = into.coefficient + from.coefficient;
      if (!same_base(into, from) || !std::isfinite(c)) continue;
      into.coefficient = c;
      from.coefficient = 0.0;
      merged = true;
      break;
    }
  return merged;
}

Expr scaled(const Term& term) {
  if (!term.base) return term.coefficient;
  if (term.coefficient == 1.0) return *term.base;
  if (term.coefficient == -1.0) return negation(*term.base);
  return product(term.coefficient, *term.base);
}

/// Left-nested sum of the terms in their order, the number last.
Expr rebuild(const std::vector<Term>& a, const std::vector<Term>& b) {
  Expr total = 0.0;
  double number = 0.0;
  for (const auto* list : {&a, &b})
    for (const Term& term : *list) {
      if (!term.base) number += term.coefficient;
      if (!term.base || term.coefficient == 0.0) continue;
      const Expr next = scaled(term);
      total = total.is(0.0) ? next : ordered(Op::add, total, next);
    }
  if (number == 0.0) return total;
  return total.is(0.0) ? Expr(number) : ordered(Op::add, total, number);
}

} // namespace

Term split_coefficient(const Expr& e) {
  if (e.is_constant()) return {e.value(), nullptr};
  if (e.op() == Op::neg) {
    const Term inner = split_coefficient(e.args()[0]);
    return {-inner.coefficient, inner.base};
  }
  if (e.op() == Op::mul && e.args()[0].is_constant()) return {e.args()[0].value(), &e.args()[1]};
  return {1.0, &e};
}

Expr sum(const Expr& a, const Expr& b) {
  if (a.is(0.0)) return b;
  if (b.is(0.0)) return a;
  std::vector<Term> left = terms_of(a), right = terms_of(b);
  if (!merge(left, right)) return ordered(Op::add, a, b);
  return rebuild(left, right);
}

Expr negation(const Expr& a) {
  if (a.is_constant()) return -a.value();
  if (a.op() == Op::neg) return a.args()[0];
  if (a.op() == Op::mul && a.args()[0].is_constant())
    return product(-a.args()[0].value(), a.args()[1]);
  if (a.op() == Op::div && a.args()[0].is_constant())
    return quotient(-a.args()[0].value(), a.args()[1]);
  return ExprAccess::raw(Op::neg, {a});
}

} // namespace hvi::solver::rules
