// Growth on a ray: it holds every sampled value, and knows which case of an expression holds there.
#include "random_expr.hpp"
#include "solver/kernel/tail.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace hvi::solver;
using namespace hvi::solver::test;

namespace {

const Expr x = Expr::variable(0), y = Expr::variable(1);

Tail tail(const Expr& e, double sign, double from) {
  return tail_of(e, {0, sign, from}, [](Slot) { return Bounds{-0.5, 2.0}; });
}

/// Is v between the ends of a tail at |r|? A value as small as rounding of `size` says nothing.
bool holds(const Tail& found, double r, double v, double size) {
  const double scale = std::pow(r, found.power) * std::pow(std::log(r), found.log_power);
  const double slack = 1e-12 * size;
  return found.coefficient.low * scale <= v + slack && v - slack <= found.coefficient.high * scale;
}

} // namespace

TEST(Tail, HoldsSampledValues) {
  RandomTrees random(23,
                     {Op::add, Op::add, Op::mul, Op::mul, Op::neg, Op::div, Op::pow, Op::min,
                      Op::max, Op::abs, Op::exp, Op::log, Op::sqrt, Op::cosh, Op::erfc, Op::erfcx,
                      Op::select},
                     2);
  int sampled = 0, known = 0;
  for (int i = 0; i < 6000; ++i) {
    const Tree tree = random.tree(1 + i % 4);
    const double sign = i % 2 == 0 ? 1.0 : -1.0, from = i % 3 == 0 ? 3.0 : 30.0;
    const Tail found = tail(tree.expr(), sign, from);
    known += std::isfinite(found.coefficient.low) && std::isfinite(found.coefficient.high);
    for (const double times : {1.0, 1.3, 10.0, 1e3, 1e6})
      for (const double other : {-0.5, 0.3, 2.0}) {
        double size = 0.0;
        const double v = tree.evaluate(std::array{sign * from * times, other}, size);
        if (!std::isfinite(size) || size > 1e100) continue;
        ++sampled;
        EXPECT_TRUE(holds(found, from * times, v, size))
            << to_string(tree.expr()) << " at " << sign * from * times << ", " << other;
      }
  }
  EXPECT_GT(sampled, 30000);
  EXPECT_GT(known, 2000);
}

/// x^(n+1) w_n(x) has the limit 1/(2^n sqrt(pi)); erfc dies exponentially.
TEST(Tail, OfErrorFunctions) {
  for (const double n : {0.0, 1.0, 3.0}) {
    const Tail found = tail(Expr::make(Op::erfcx, {n, 2.0 * x}), 1.0, 6.0);
    EXPECT_EQ(found.power, -(n + 1.0));
    const double limit = std::pow(0.5, 2.0 * n + 1.0) / std::sqrt(M_PI); // of 2 x
    EXPECT_NEAR(found.coefficient.high, limit, 1e-13 * limit);
    EXPECT_GT(found.coefficient.low, 0.9 * limit);
    for (const double r : {6.0, 7.0, 50.0, 1e6})
      EXPECT_TRUE(holds(found, r, erfcx(n, 2.0 * r), limit)) << n << " " << r;
  }
  for (const double n : {0.0, 1.0, 4.0}) { // exp(x^2) on the other side
    const Tail grows = tail(-Expr::make(Op::erfcx, {n, x + 2.0}), -1.0, 12.0);
    EXPECT_TRUE(grows.grows() && grows.power > 10.0 && grows.coefficient.high < 0.0) << n;
    EXPECT_TRUE(holds(grows, 13.0, -erfcx(n, -11.0), 1.0)) << n;
  }
  const Tail left = tail(pow(x, 3.0) * Expr::make(Op::erfc, {x}), 1.0, 12.0);
  EXPECT_LT(left.power, -10.0);
  EXPECT_TRUE(std::isfinite(left.coefficient.high));
  EXPECT_TRUE(std::isfinite(range_of(left, {0, 1.0, 12.0}).high));
}

/// The other case would make it grow, or not die.
TEST(Tail, IsThatOfTheCaseThatHolds) {
  for (const Expr& e : {select(less_equal(5.0, x), 1.0 / x, pow(x, 2.0)),
                        select(less(x, 5.0), pow(x, 2.0), 1.0 / x)}) {
    const Tail right = tail(e, 1.0, 6.0), left = tail(e, -1.0, 6.0);
    EXPECT_EQ(right.power, -1.0) << to_string(e);
    EXPECT_NEAR(right.coefficient.low, 1.0, 1e-14);
    EXPECT_NEAR(right.coefficient.high, 1.0, 1e-14);
    EXPECT_EQ(left.power, 2.0) << to_string(e);
  }
  // Nothing tells which of these holds.
  EXPECT_EQ(tail(select(less(y, 0.0), pow(x, 2.0), 1.0 / x), 1.0, 6.0).power, 2.0);
}
