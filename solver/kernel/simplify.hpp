// Inside the kernel: the rules that simplify an operation as it is built, by group.
#pragma once

#include "solver/kernel/expr.hpp"

namespace hvi::solver::rules {

/// e = coefficient * base; a pure number has base null. The base belongs to the expression e.
struct Term {
  double coefficient;
  const Expr* base;
};
Term split_coefficient(const Expr& e);

Expr sum(const Expr& a, const Expr& b);
Expr negation(const Expr& a);
Expr product(const Expr& a, const Expr& b);
Expr quotient(const Expr& a, const Expr& b);
Expr power(const Expr& base, const Expr& exponent);
/// abs, sqrt, log, sign, ... : one argument.
Expr function(Op op, const Expr& a);
Expr extremum(Op op, const Expr& a, const Expr& b);
Expr comparison(Op op, const Expr& a, const Expr& b);
Expr conjunction(Op op, const Expr& a, const Expr& b); ///< and, or
Expr selection(const Expr& condition, const Expr& then, const Expr& otherwise);

/// The operands of a commutative operation in the order that makes a op b and b op a one node:
/// constants last (`constant_first`: first), larger operands before smaller ones.
Expr ordered(Op op, const Expr& a, const Expr& b, bool constant_first = false);

} // namespace hvi::solver::rules
