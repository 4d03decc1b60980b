// Addends, factors, affine parts, signs (algebra.hpp).
#include "solver/kernel/algebra.hpp"

#include "solver/kernel/node.hpp"
#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

using Affine = std::optional<std::pair<Expr, Expr>>;

/// Affine parts of one node from those of its arguments that depend on the slot.
Affine affine_node(const Expr& e, Slot slot, const NodeMap<Affine>& done) {
  if (e.op() == Op::slot) return {{0.0, 1.0}};
  std::vector<std::pair<Expr, Expr>> part;
  for (const Expr& arg : e.args()) {
    const Affine found = arg.depends_on(slot) ? done.at(arg.id()) : Affine({arg, Expr(0.0)});
    if (!found) return {};
    part.push_back(*found);
  }
  switch (e.op()) {
  case Op::add:
    return {{part[0].first + part[1].first, part[0].second + part[1].second}};
  case Op::neg:
    return {{-part[0].first, -part[0].second}};
  case Op::mul:
    if (!part[0].second.is(0.0) && !part[1].second.is(0.0)) return {};
    return {{part[0].first * part[1].first,
             part[0].first * part[1].second + part[0].second * part[1].first}};
  case Op::div:
    if (!part[1].second.is(0.0)) return {};
    return {{part[0].first / part[1].first, part[0].second / part[1].first}};
  case Op::select:
    if (e.args()[0].depends_on(slot)) return {};
    return {{select(e.args()[0], part[1].first, part[2].first),
             select(e.args()[0], part[1].second, part[2].second)}};
  default:
    return {};
  }
}

Affine affine_as_written(const Expr& e, Slot slot) {
  if (!e.depends_on(slot)) return {{e, 0.0}};
  NodeMap<Affine> done;
  postorder(
      e, [slot](const Expr& node) { return node.depends_on(slot); },
      [&](const Expr& node) { done.emplace(node.id(), affine_node(node, slot, done)); });
  return done.at(e.id());
}

/// Factors of a quotient's denominator, turned over.
Expr reciprocal(const Expr& e) {
  if (e.op() == Op::pow && e.args()[1].is_constant()) return pow(e.args()[0], -e.args()[1].value());
  return 1.0 / e;
}

bool is_even(const Expr& e) { return e.is_constant() && std::fmod(e.value(), 2.0) == 0.0; }

bool nonnegative_node(const Expr& e, const NodeMap<bool>& done) {
  const auto arg = [&](std::size_t i) { return done.at(e.args()[i].id()); };
  switch (e.op()) {
  case Op::constant:
    return e.value() >= 0.0;
  case Op::slot:
    return e.slot() == slot::lag;
  case Op::abs:
  case Op::exp:
  case Op::sqrt:
  case Op::cosh:
  case Op::acos:
  case Op::erfc:
  case Op::erfcx:
  case Op::less:
  case Op::less_equal:
  case Op::equal:
  case Op::logic_and:
  case Op::logic_or:
  case Op::logic_not:
    return true;
  case Op::pow:
    return arg(0) || is_even(e.args()[1]);
  case Op::add:
  case Op::mul:
  case Op::div:
  case Op::min:
    return arg(0) && arg(1);
  case Op::max:
    return arg(0) || arg(1);
  case Op::sign:
  case Op::atan:
  case Op::sinh:
  case Op::tanh:
  case Op::erf:
    return arg(0);
  case Op::select:
    return arg(1) && arg(2);
  default:
    return false;
  }
}

} // namespace

std::vector<Expr> addends(const Expr& e) {
  std::vector<Expr> terms;
  std::vector<std::pair<Expr, bool>> stack{{e, false}};
  while (!stack.empty()) {
    const auto [at, negative] = std::move(stack.back());
    stack.pop_back();
    if (at.op() == Op::add) {
      stack.emplace_back(at.args()[1], negative);
      stack.emplace_back(at.args()[0], negative);
    } else if (at.op() == Op::neg && at.args()[0].op() == Op::add) {
      stack.emplace_back(at.args()[0], !negative);
    } else if (!at.is(0.0)) {
      terms.push_back(negative ? -at : at);
    }
  }
  return terms;
}

Expr sum_of(const std::vector<Expr>& terms) {
  Expr total = 0.0;
  for (const Expr& term : terms) total = total + term;
  return total;
}

std::vector<Expr> factors(const Expr& e) {
  struct Part {
    Expr expr;
    double exponent;
  };
  std::vector<Expr> found;
  std::vector<Part> stack{{e, 1.0}};
  while (!stack.empty()) {
    const auto [at, n] = std::move(stack.back());
    stack.pop_back();
    if (at.op() == Op::mul) {
      stack.push_back({at.args()[1], n});
      stack.push_back({at.args()[0], n});
    } else if (at.op() == Op::div) {
      stack.push_back({at.args()[1], -n});
      stack.push_back({at.args()[0], n});
    } else if (at.op() == Op::neg) {
      stack.push_back({at.args()[0], n});
      if (std::fmod(n, 2.0) != 0.0) found.emplace_back(-1.0);
    } else if (at.op() == Op::pow && at.args()[1].is_constant() &&
               is_multiplied_power(at.args()[1].value() * n) &&
               is_multiplied_power(at.args()[1].value())) {
      stack.push_back({at.args()[0], n * at.args()[1].value()});
    } else if (n == -1.0) {
      found.push_back(reciprocal(at));
    } else if (const Expr factor = pow(at, n); !factor.is(1.0)) {
      found.push_back(factor);
    }
  }
  return found;
}

std::optional<std::pair<Expr, Expr>> affine_in(const Expr& e, Slot slot) {
  if (Affine found = affine_as_written(e, slot)) return found;
  const Expr expanded = expand(e); // (1 + s)^2 - s^2
  return expanded == e ? Affine() : affine_as_written(expanded, slot);
}

std::vector<Expr> table_readings(const Expr& e) {
  std::vector<Expr> found;
  postorder(e, [&](const Expr& node) {
    if (node.op() == Op::table || node.op() == Op::table_slope) found.push_back(node);
  });
  return found;
}

bool is_nonnegative(const Expr& e) {
  NodeMap<bool> done;
  postorder(e, [&](const Expr& node) { done.emplace(node.id(), nonnegative_node(node, done)); });
  return done.at(e.id());
}

} // namespace hvi::solver
