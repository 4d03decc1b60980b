// Quotients of exponentials that do not overflow (overflow.hpp).
#include "solver/kernel/overflow.hpp"

#include "solver/kernel/algebra.hpp"

#include <algorithm>
#include <vector>

namespace hvi::solver {

namespace {

bool has(const Expr& e, std::initializer_list<Op> ops) {
  if (std::find(ops.begin(), ops.end(), e.op()) != ops.end()) return true;
  return std::ranges::any_of(e.args(), [&](const Expr& a) { return has(a, ops); });
}

struct PowerOfSlot {
  Expr base;
  double exponent;
};

/// base^exponent of a factor: reciprocals and constant powers taken apart.
PowerOfSlot power_of(const Expr& factor) {
  if (factor.op() == Op::div && factor.args()[0].is(1.0)) {
    PowerOfSlot p = power_of(factor.args()[1]);
    p.exponent = -p.exponent;
    return p;
  }
  if (factor.op() == Op::pow && factor.args()[1].is_constant()) {
    PowerOfSlot p = power_of(factor.args()[0]);
    p.exponent *= factor.args()[1].value();
    return p;
  }
  return {factor, 1.0};
}

bool is_exponential_sum(const Expr& e) { return e.op() == Op::add && has(e, {Op::exp}); }

/// A product as exp(exponent) times powers.
struct Product {
  Expr exponent = 0.0;
  std::vector<PowerOfSlot> powers;

  explicit Product(const Expr& term) {
    for (const Expr& factor : factors(term)) {
      const PowerOfSlot p = power_of(factor);
      if (p.base.op() == Op::exp)
        exponent = exponent + Expr(p.exponent) * p.base.args()[0];
      else
        powers.push_back(p);
    }
    exponent = expand(exponent);
  }

  Expr result() const {
    Expr out = exponent.is(0.0) ? Expr(1.0) : exp(exponent);
    for (const PowerOfSlot& p : powers)
      out = p.exponent < 0.0 ? out / (p.exponent == -1.0 ? p.base : pow(p.base, -p.exponent))
                             : out * (p.exponent == 1.0 ? p.base : pow(p.base, p.exponent));
    return out;
  }
};

/// exp(a) S^-n = (S exp(-a/n))^-n for the sum of exponentials with the largest n.
bool move_into_sum(Product& product) {
  if (product.exponent.is(0.0)) return false;
  PowerOfSlot* sum = nullptr;
  for (PowerOfSlot& p : product.powers)
    if (is_exponential_sum(p.base) && p.exponent < 0.0 && (!sum || p.exponent < sum->exponent))
      sum = &p;
  if (!sum) return false;
  Expr moved = 0.0;
  for (const Expr& addend : addends(sum->base)) {
    Product part(addend);
    part.exponent = expand(part.exponent + product.exponent / Expr(sum->exponent));
    moved = moved + part.result();
  }
  sum->base = moved;
  product.exponent = 0.0;
  return true;
}

/// sinh(a) / cosh(a) = tanh(a), as often as both are there.
bool make_tanh(Product& product) {
  for (const PowerOfSlot& up : product.powers)
    for (const PowerOfSlot& down : product.powers) {
      if (up.base.op() != Op::sinh || down.base.op() != Op::cosh) continue;
      if (!(up.exponent >= 1.0 && down.exponent <= -1.0)) continue;
      if (!(up.base.args()[0] == down.base.args()[0])) continue;
      const double shared = std::min(up.exponent, -down.exponent);
      const Expr argument = up.base.args()[0];
      const auto i = static_cast<std::size_t>(&up - product.powers.data()),
                 j = static_cast<std::size_t>(&down - product.powers.data());
      product.powers[i].exponent -= shared, product.powers[j].exponent += shared;
      product.powers.push_back({Expr::make(Op::tanh, {argument}), shared});
      std::erase_if(product.powers, [](const PowerOfSlot& p) { return p.exponent == 0.0; });
      make_tanh(product);
      return true;
    }
  return false;
}

} // namespace

Expr without_overflow(const Expr& e) {
  if (!has(e, {Op::exp, Op::cosh}) || !has(e, {Op::div, Op::pow})) return e;
  bool changed = false;
  Expr out = 0.0;
  for (const Expr& term : addends(expand(e))) {
    Product product(term);
    const bool here = move_into_sum(product), there = make_tanh(product);
    changed = changed || here || there;
    out = out + (here || there ? product.result() : term);
  }
  return changed ? out : e;
}

} // namespace hvi::solver
