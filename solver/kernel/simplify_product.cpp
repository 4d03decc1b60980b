// Simplification of products, quotients and powers. Constants are gathered in front of a product;
// a division by a constant stays a division unless the reciprocal is exact.
#include "solver/kernel/node.hpp"
#include "solver/kernel/scalar.hpp"
#include "solver/kernel/simplify.hpp"

#include <cmath>

namespace hvi::solver::rules {

namespace {

bool is_power_of_two(double v) {
  int exponent = 0;
  return std::abs(std::frexp(v, &exponent)) == 0.5;
}

bool divides_exactly(double a, double b) {
  const double q = a / b;
  return std::isfinite(q) && std::fma(q, b, -a) == 0.0 && (a == 0.0 || std::isnormal(q));
}

/// c * e with e free of a leading number or sign.
Expr scaled(double c, const Expr& e) {
  if (c == 0.0) return 0.0;
  if (c == 1.0) return e;
  if (c == -1.0) return negation(e);
  if (e.op() == Op::div && e.args()[1].is_constant() && divides_exactly(c, e.args()[1].value()))
    return product(c / e.args()[1].value(), e.args()[0]);
  return ExprAccess::raw(Op::mul, {Expr(c), e});
}

/// e as base^n with a positive whole n.
std::pair<const Expr*, double> split_power(const Expr& e) {
  if (e.op() != Op::pow || !e.args()[1].is_constant()) return {&e, 1.0};
  const double n = e.args()[1].value();
  if (n < 1.0 || !is_multiplied_power(n)) return {&e, 1.0};
  return {&e.args()[0], n};
}

/// Product of operands without number or sign.
Expr plain_product(const Expr& a, const Expr& b) {
  const auto [p, m] = split_power(a);
  const auto [q, n] = split_power(b);
  if (m + n <= largest_multiplied_power && *p == *q) return power(*p, m + n);
  return ordered(Op::mul, a, b, true);
}

Expr divided_by_number(const Expr& a, double d) {
  if (is_power_of_two(d) && std::isfinite(1.0 / d)) return product(a, 1.0 / d);
  const Term term = split_coefficient(a);
  if (term.base && term.coefficient != 1.0 && divides_exactly(term.coefficient, d))
    return product(term.coefficient / d, *term.base);
  if (a.op() == Op::div && a.args()[1].is_constant()) {
    const double e = a.args()[1].value(), both = e * d;
    if (std::isnormal(both) && std::fma(e, d, -both) == 0.0) return quotient(a.args()[0], both);
  }
  return ExprAccess::raw(Op::div, {a, Expr(d)});
}

Expr whole_power(const Expr& base, double n) {
  const bool even = std::fmod(n, 2.0) == 0.0;
  if (base.op() == Op::neg) {
    const Expr p = power(base.args()[0], n);
    return even ? p : negation(p);
  }
  if (base.op() == Op::abs && even) return power(base.args()[0], n);
  const auto [inner, m] = split_power(base);
  if (m > 1.0 && n > 0.0 && m * n <= largest_multiplied_power) return power(*inner, m * n);
  return ExprAccess::raw(Op::pow, {base, Expr(n)});
}

} // namespace

Expr product(const Expr& a, const Expr& b) {
  const Term p = split_coefficient(a), q = split_coefficient(b);
  if ((!p.base && p.coefficient == 0.0) || (!q.base && q.coefficient == 0.0)) return 0.0;
  const double c = p.coefficient * q.coefficient;
  if (!std::isfinite(c) || (c == 0.0 && p.coefficient != 0.0)) // overflow or underflow: as given
    return ordered(Op::mul, a, b, true);
  if (!p.base) return q.base ? scaled(c, *q.base) : Expr(c);
  if (!q.base) return scaled(c, *p.base);
  return scaled(c, plain_product(*p.base, *q.base));
}

Expr quotient(const Expr& a, const Expr& b) {
  if (b.is(1.0)) return a;
  if (a.op() == Op::neg) return negation(quotient(a.args()[0], b));
  if (b.op() == Op::neg) return negation(quotient(a, b.args()[0]));
  if (b.is_constant() && !b.is(0.0)) {
    if (b.is(-1.0)) return negation(a);
    return divided_by_number(a, b.value());
  }
  if (a.is(0.0) && !b.is_constant()) return 0.0;
  if (a.op() == Op::mul && a.args()[0].is_constant())
    return product(a.args()[0], quotient(a.args()[1], b));
  return ExprAccess::raw(Op::div, {a, b});
}

Expr power(const Expr& base, const Expr& exponent) {
  if (exponent.is(0.0) || base.is(1.0)) return 1.0;
  if (exponent.is(1.0)) return base;
  if (exponent.is_constant() && is_multiplied_power(exponent.value()))
    return whole_power(base, exponent.value());
  return ExprAccess::raw(Op::pow, {base, exponent});
}

} // namespace hvi::solver::rules
