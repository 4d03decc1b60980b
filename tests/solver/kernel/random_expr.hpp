// Random expression trees for the tests, with an evaluation of their own: no simplification, no
// sharing, plain recursion. Seeded: every run sees the same trees.
#pragma once

#include "solver/kernel/expr.hpp"
#include "solver/kernel/scalar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace hvi::solver::test {

/// The formula as written.
struct Tree {
  Op op = Op::constant;
  double value = 0.0;
  Slot slot = 0;
  std::vector<Tree> args;

  Expr expr() const {
    if (op == Op::constant) return value;
    if (op == Op::slot) return Expr::variable(slot);
    std::vector<Expr> built;
    for (const Tree& arg : args) built.push_back(arg.expr());
    return Expr::make(op, built);
  }

  /// Value at a point; `size` becomes the largest intermediate value, which scales rounding errors.
  double evaluate(std::span<const double> point, double& size) const {
    double result = value;
    if (op == Op::slot) {
      result = point[static_cast<std::size_t>(slot)];
    } else if (op != Op::constant) {
      std::array<double, 3> v{};
      for (std::size_t i = 0; i < args.size(); ++i) v[i] = args[i].evaluate(point, size);
      result = apply(op, v[0], v[1], v[2]);
      // On its cut atan2 tells 0 from -0, which simplification does not.
      if (op == Op::atan2 && v[0] == 0.0 && v[1] <= 0.0) size = HUGE_VAL;
    }
    size = std::isfinite(result) ? std::max(size, std::abs(result)) : HUGE_VAL;
    return result;
  }
};

class RandomTrees {
public:
  explicit RandomTrees(unsigned seed, std::vector<Op> ops, int slots = 4)
      : engine_(seed), ops_(std::move(ops)), slots_(slots) {}

  Tree tree(int depth) {
    if (depth == 0 || below(8) == 0) return leaf();
    Tree t;
    t.op = ops_[static_cast<std::size_t>(below(static_cast<int>(ops_.size())))];
    if (t.op == Op::pow) { // whole exponents: any base will do
      t.args = {tree(depth - 1), constant(below(7) - 2)};
      return t;
    }
    if (t.op == Op::erfcx) { // whole orders
      t.args = {constant(below(4)), tree(depth - 1)};
      return t;
    }
    const int count = arguments(t.op);
    for (int i = 0; i < count; ++i) t.args.push_back(tree(depth - 1));
    if (t.op == Op::select) t.args[0] = condition(depth - 1);
    return t;
  }

  std::vector<double> point() {
    std::vector<double> p;
    std::uniform_real_distribution<double> value(-2.0, 2.0);
    for (int i = 0; i < slots_; ++i) p.push_back(value(engine_));
    return p;
  }

  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }

private:
  static int arguments(Op op) {
    switch (op) {
    case Op::add:
    case Op::mul:
    case Op::div:
    case Op::min:
    case Op::max:
    case Op::atan2:
      return 2;
    case Op::select:
      return 3;
    default:
      return 1;
    }
  }

  static Tree constant(double value) { return {Op::constant, value, 0, {}}; }

  Tree leaf() {
    if (below(3) != 0) return {Op::slot, 0.0, below(slots_), {}};
    constexpr std::array values{0.0, 1.0, -1.0, 2.0, 0.5, -3.0, 0.1, 7.0};
    return constant(values[static_cast<std::size_t>(below(values.size()))]);
  }

  Tree condition(int depth) {
    Tree less{below(2) == 0 ? Op::less : Op::less_equal, 0.0, 0, {tree(depth), tree(depth)}};
    if (below(3) != 0) return less;
    Tree other{Op::less, 0.0, 0, {leaf(), leaf()}};
    if (below(3) == 0) return {Op::logic_not, 0.0, 0, {less}};
    return {below(2) == 0 ? Op::logic_and : Op::logic_or, 0.0, 0, {less, other}};
  }

  std::mt19937 engine_;
  std::vector<Op> ops_;
  int slots_;
};

inline const std::vector<Op> arithmetic{Op::add, Op::add, Op::mul, Op::mul,
                                        Op::neg, Op::div, Op::pow};
inline const std::vector<Op> everything{
    Op::add,  Op::add,  Op::add, Op::mul,  Op::mul,   Op::mul,   Op::neg,   Op::div,
    Op::pow,  Op::min,  Op::max, Op::abs,  Op::sign,  Op::exp,   Op::log,   Op::sqrt,
    Op::sin,  Op::cos,  Op::tan, Op::asin, Op::acos,  Op::atan,  Op::atan2, Op::sinh,
    Op::cosh, Op::tanh, Op::erf, Op::erfc, Op::erfcx, Op::select};

inline double value_at(const Expr& e, std::span<const double> point) {
  return evaluate(e, [&](Slot s) { return point[static_cast<std::size_t>(s)]; });
}

} // namespace hvi::solver::test
