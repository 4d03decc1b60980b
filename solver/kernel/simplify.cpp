// Building an operation: constant folding, then the rules of its group. What cannot be folded to a
// finite number is kept, so that the language can point at it.
#include "solver/kernel/simplify.hpp"

#include "solver/kernel/node.hpp"
#include "solver/kernel/scalar.hpp"
#include "solver/kernel/table.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hvi::solver {

bool is_boolean(const Expr& e) {
  switch (e.op()) {
  case Op::less:
  case Op::less_equal:
  case Op::equal:
  case Op::logic_and:
  case Op::logic_or:
  case Op::logic_not:
    return true;
  default:
    return e.is(0.0) || e.is(1.0);
  }
}

namespace {

/// The value if all arguments are numbers and the result is finite, else NaN.
double folded(Op op, const std::vector<Expr>& args) {
  double v[3] = {0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < args.size(); ++i) v[i] = args[i].value();
  const double result = apply(op, v[0], v[1], v[2]);
  return std::isfinite(result) ? result : not_a_number;
}

Expr simplified(Op op, std::vector<Expr> args) {
  switch (op) {
  case Op::add:
    return rules::sum(args[0], args[1]);
  case Op::mul:
    return rules::product(args[0], args[1]);
  case Op::div:
    return rules::quotient(args[0], args[1]);
  case Op::neg:
    return rules::negation(args[0]);
  case Op::pow:
    return rules::power(args[0], args[1]);
  case Op::min:
  case Op::max:
    return rules::extremum(op, args[0], args[1]);
  case Op::less:
  case Op::less_equal:
  case Op::equal:
    return rules::comparison(op, args[0], args[1]);
  case Op::logic_and:
  case Op::logic_or:
    return rules::conjunction(op, args[0], args[1]);
  case Op::select:
    return rules::selection(args[0], args[1], args[2]);
  case Op::logic_not:
  case Op::abs:
  case Op::sqrt:
  case Op::log:
    return rules::function(op, args[0]);
  default:
    return ExprAccess::raw(op, std::move(args));
  }
}

} // namespace

Expr Expr::make(Op op, std::vector<Expr> args) {
  if (op == Op::table || op == Op::table_slope || arity(op) != static_cast<int>(args.size()))
    throw std::invalid_argument("Expr::make: wrong number of arguments");
  if (std::ranges::all_of(args, &Expr::is_constant)) {
    const double value = folded(op, args);
    return std::isnan(value) ? ExprAccess::raw(op, std::move(args)) : Expr(value);
  }
  return simplified(op, std::move(args));
}

Expr Expr::tabulated(std::shared_ptr<const Table> table, Expr x, bool slope) {
  if (!table) throw std::invalid_argument("Expr::tabulated: no table");
  if (x.is_constant()) {
    const double value = slope ? table->slope(x.value()) : table->value(x.value());
    if (std::isfinite(value)) return value;
  }
  return ExprAccess::raw(slope ? Op::table_slope : Op::table, {std::move(x)}, std::move(table));
}

Expr with_args(const Expr& e, std::vector<Expr> args) {
  const bool same = std::ranges::equal(e.args(), args, {}, &Expr::id, &Expr::id);
  if (same) return e;
  if (e.table()) return Expr::tabulated(e.table(), args[0], e.op() == Op::table_slope);
  return Expr::make(e.op(), std::move(args));
}

Expr operator+(const Expr& a, const Expr& b) { return Expr::make(Op::add, {a, b}); }
Expr operator-(const Expr& a, const Expr& b) { return Expr::make(Op::add, {a, -b}); }
Expr operator-(const Expr& a) { return rules::negation(a); }
Expr operator*(const Expr& a, const Expr& b) { return Expr::make(Op::mul, {a, b}); }
Expr operator/(const Expr& a, const Expr& b) { return Expr::make(Op::div, {a, b}); }
Expr pow(const Expr& a, const Expr& b) { return Expr::make(Op::pow, {a, b}); }
Expr min(const Expr& a, const Expr& b) { return Expr::make(Op::min, {a, b}); }
Expr max(const Expr& a, const Expr& b) { return Expr::make(Op::max, {a, b}); }
Expr abs(const Expr& a) { return Expr::make(Op::abs, {a}); }
Expr exp(const Expr& a) { return Expr::make(Op::exp, {a}); }
Expr log(const Expr& a) { return Expr::make(Op::log, {a}); }
Expr sqrt(const Expr& a) { return Expr::make(Op::sqrt, {a}); }
Expr sin(const Expr& a) { return Expr::make(Op::sin, {a}); }
Expr cos(const Expr& a) { return Expr::make(Op::cos, {a}); }
Expr less(const Expr& a, const Expr& b) { return Expr::make(Op::less, {a, b}); }
Expr less_equal(const Expr& a, const Expr& b) { return Expr::make(Op::less_equal, {a, b}); }
Expr select(const Expr& condition, const Expr& then, const Expr& otherwise) {
  return Expr::make(Op::select, {condition, then, otherwise});
}

} // namespace hvi::solver
