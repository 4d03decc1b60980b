// Symbolic derivatives: one walk over the distinct nodes that depend on the slot.
#include "solver/common/failure.hpp"
#include "solver/kernel/node.hpp"

#include <cmath>
#include <numbers>

namespace hvi::solver {

namespace {

Expr fn(Op op, const Expr& a) { return Expr::make(op, {a}); }
Expr fn(Op op, const Expr& a, const Expr& b) { return Expr::make(op, {a, b}); }

/// d/dx E_{a,b}(x). Near 0: (E_{a,a+b-1} - (b-1) E_{a,a+b}) / a. Far from 0 the leading terms of
/// that difference cancel (unless b = 1), and (E_{a,b-1} - (b-1) E_{a,b}) / (a x) takes over.
Expr mittag_leffler_slope(const Expr& a, const Expr& b, const Expr& x) {
  const auto e = [&](const Expr& beta) { return Expr::make(Op::mittag_leffler, {a, beta, x}); };
  Expr near = (e(a + b - 1.0) - (b - 1.0) * e(a + b)) / a;
  if (b.is(1.0)) return near;
  const Expr far = (e(b - 1.0) - (b - 1.0) * e(b)) / (a * x);
  return select(less_equal(abs(x), 1.0), near, far);
}

/// f'(x) for the functions of one variable. `node` is f(x).
Expr outer_slope(const Expr& node) {
  const Expr& x = node.args().back();
  const auto& args = node.args();
  switch (node.op()) {
  case Op::abs:
    return fn(Op::sign, x);
  case Op::exp:
    return node;
  case Op::log:
    return 1.0 / x;
  case Op::sqrt:
    return 0.5 / node;
  case Op::sin:
    return cos(x);
  case Op::cos:
    return -sin(x);
  case Op::tan:
    return 1.0 + pow(node, 2.0);
  case Op::asin:
    return 1.0 / sqrt(1.0 - pow(x, 2.0));
  case Op::acos:
    return -1.0 / sqrt(1.0 - pow(x, 2.0));
  case Op::atan:
    return 1.0 / (1.0 + pow(x, 2.0));
  case Op::sinh:
    return fn(Op::cosh, x);
  case Op::cosh:
    return fn(Op::sinh, x);
  case Op::tanh:
    return 1.0 - pow(node, 2.0);
  case Op::erf:
    return 2.0 * std::numbers::inv_sqrtpi * exp(-pow(x, 2.0));
  case Op::erfc:
    return -2.0 * std::numbers::inv_sqrtpi * exp(-pow(x, 2.0));
  case Op::gamma:
    return node * fn(Op::polygamma, 0.0, x);
  case Op::polygamma:
    return fn(Op::polygamma, args[0] + 1.0, x);
  case Op::bessel_j:
    return 0.5 * (fn(Op::bessel_j, args[0] - 1.0, x) - fn(Op::bessel_j, args[0] + 1.0, x));
  case Op::mittag_leffler:
    return mittag_leffler_slope(args[0], args[1], x);
  case Op::erfcx: // 2 x erfcx - 2/sqrt(pi) without the cancellation
    return -2.0 * (args[0] + 1.0) * fn(Op::erfcx, args[0] + 1.0, x);
  case Op::table:
    return Expr::tabulated(node.table(), x, true);
  default:
    return 0.0; // sign, comparisons, logic, the slope of a table: piecewise constant
  }
}

/// (a^b)' with da, db the derivatives of a and b.
Expr power_slope(const Expr& node, const Expr& da, const Expr& db) {
  const Expr &a = node.args()[0], &b = node.args()[1];
  const Expr by_base = da.is(0.0) ? Expr(0.0) : b * pow(a, b - 1.0) * da;
  const Expr by_exponent = db.is(0.0) ? Expr(0.0) : node * log(a) * db;
  return by_base + by_exponent;
}

/// The rule of one node; d[i] is the derivative of argument i.
Expr rule(const Expr& node, const std::vector<Expr>& d) {
  const auto& a = node.args();
  switch (node.op()) {
  case Op::constant:
    return 0.0;
  case Op::slot:
    return 1.0;
  case Op::add:
    return d[0] + d[1];
  case Op::mul:
    return d[0] * a[1] + a[0] * d[1];
  case Op::neg:
    return -d[0];
  case Op::div: // (a/b)' = a'/b - (a/b) b'/b
    if (d[1].is(0.0)) return d[0] / a[1];
    return d[0] / a[1] - node * (d[1] / a[1]);
  case Op::pow:
    return power_slope(node, d[0], d[1]);
  case Op::min:
    return select(less(a[0], a[1]), d[0], d[1]);
  case Op::max:
    return select(less(a[1], a[0]), d[0], d[1]);
  case Op::atan2:
    return (d[0] * a[1] - d[1] * a[0]) / (pow(a[0], 2.0) + pow(a[1], 2.0));
  case Op::select:
    return select(a[0], d[1], d[2]);
  case Op::bessel_j:
  case Op::erfcx:
  case Op::mittag_leffler:
  case Op::polygamma:
    for (std::size_t i = 0; i + 1 < d.size(); ++i)
      if (!d[i].is(0.0))
        throw Failure(FailureKind::bad_value, Origin{},
                      "no derivative with respect to the order of a Bessel function or of erfcx or "
                      "a parameter of mittag_leffler",
                      "keep these parameters constant where a derivative is needed");
    return outer_slope(node) * d.back();
  default:
    return d[0].is(0.0) ? Expr(0.0) : outer_slope(node) * d[0];
  }
}

} // namespace

Expr derivative(const Expr& expr, Slot slot) {
  if (!expr.depends_on(slot)) return 0.0;
  NodeMap<Expr> found;
  const auto depends = [slot](const Expr& e) { return e.depends_on(slot); };
  const Expr zero(0.0);
  std::vector<Expr> d;
  postorder(expr, depends, [&](const Expr& e) {
    d.clear();
    for (const Expr& arg : e.args()) d.push_back(depends(arg) ? found.at(arg.id()) : zero);
    found.emplace(e.id(), rule(e, d));
  });
  return found.at(expr.id());
}

} // namespace hvi::solver
