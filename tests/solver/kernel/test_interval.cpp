// Interval bounds: they hold every sampled value, and they are sharp where they can be.
#include "random_expr.hpp"
#include "solver/kernel/interval.hpp"
#include "solver/kernel/overflow.hpp"
#include "solver/kernel/table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

using namespace hvi::solver;
using namespace hvi::solver::test;

namespace {

const Expr x = Expr::variable(0), y = Expr::variable(1);

Bounds on(const Expr& e, double low, double high) {
  return bounds(e, [=](Slot) { return Bounds{low, high}; });
}

void expect_bounds(const Bounds& b, double low, double high) {
  EXPECT_LE(b.low, low);
  EXPECT_GE(b.high, high);
  EXPECT_NEAR(b.low, low, 1e-10 * (1.0 + std::abs(low)));
  EXPECT_NEAR(b.high, high, 1e-10 * (1.0 + std::abs(high)));
}

/// Is a part of e infinite in floating point? Then NaN may follow where mathematics has a value.
bool overflows(const Expr& e, const std::vector<double>& point) {
  bool found = false;
  transform(e, [&](const Expr& part) {
    found = found || std::isinf(value_at(part, point));
    return part;
  });
  return found;
}

/// Samples e on [low, high] and checks that the bounds hold.
void expect_contained(const Expr& e, double low, double high) {
  const Bounds b = on(e, low, high);
  for (int k = 0; k <= 200; ++k) {
    const double v = value_at(e, std::vector<double>(4, low + (high - low) * k / 200.0));
    if (std::isfinite(v))
      EXPECT_TRUE(b.contains(v)) << to_string(e) << " " << v;
    else
      EXPECT_FALSE(b.defined) << to_string(e);
  }
}

} // namespace

TEST(Interval, HoldsSampledValues) {
  RandomTrees random(17, everything);
  int finite = 0;
  for (int i = 0; i < 4000; ++i) {
    const Expr e = random.tree(1 + i % 5).expr();
    const auto a = random.point(), b = random.point();
    const auto box = [&](Slot s) {
      const auto [low, high] =
          std::minmax(a[static_cast<std::size_t>(s)], b[static_cast<std::size_t>(s)]);
      return Bounds{low, high};
    };
    const Bounds found = bounds(e, box);
    finite += std::isfinite(found.low) && std::isfinite(found.high);
    for (int k = 0; k < 20; ++k) {
      std::vector<double> p(4);
      for (std::size_t s = 0; s < 4; ++s) {
        const double w = random.below(11) / 10.0;
        p[s] = std::clamp(w * a[s] + (1.0 - w) * b[s], std::min(a[s], b[s]), std::max(a[s], b[s]));
      }
      const double v = value_at(e, p);
      if (!std::isfinite(v)) // a pole, or nothing
        EXPECT_TRUE(!found.defined || overflows(e, p)) << to_string(e);
      else
        EXPECT_TRUE(found.contains(v)) << to_string(e) << " = " << v;
    }
  }
  EXPECT_GT(finite, 2000);
}

TEST(Interval, IsSharpForSingleOccurrences) {
  expect_bounds(on(pow(x, 2.0), -1.0, 2.0), 0.0, 4.0);
  expect_bounds(on(pow(x, 3.0), -1.0, 2.0), -1.0, 8.0);
  expect_bounds(on(sin(x), 0.0, 3.0), 0.0, 1.0);
  expect_bounds(on(cos(x), 3.0, 4.0), -1.0, std::cos(4.0));
  expect_bounds(on(exp(-pow(x, 2.0)), -1.0, 2.0), std::exp(-4.0), 1.0);
  expect_bounds(on(2.0 - 3.0 * x, -1.0, 2.0), -4.0, 5.0);
  expect_bounds(on(1.0 / x, 2.0, 4.0), 0.25, 0.5);
  expect_bounds(on(abs(x), -1.0, 2.0), 0.0, 2.0);
  expect_bounds(on(max(x, 0.5), -1.0, 2.0), 0.5, 2.0);
  expect_bounds(on(Expr::make(Op::gamma, {x}), 1.0, 3.0), 0.8856031944108886, 2.0);
  // small values have a sign and as many digits as others
  const Bounds left = on(Expr::make(Op::erfc, {x}), 10.0, 20.0);
  EXPECT_NEAR(left.high, std::erfc(10.0), 1e-13 * std::erfc(10.0));
  EXPECT_GT(left.low, 0.0);
  const Bounds scaled = on(Expr::make(Op::erfcx, {2.0, x}), 1e3, 1e9);
  EXPECT_NEAR(scaled.high, std::numbers::inv_sqrtpi / 4e9, 1e-14);
  EXPECT_GT(scaled.low, 0.0);
}

/// atan2 jumps on the half line x < 0, y = 0, however short the part of it is that a box has.
TEST(Interval, AnglesGoRoundTheOrigin) {
  const Expr angle = Expr::make(Op::atan2, {y, x});
  const auto over = [&](double low, double high) {
    return bounds(angle, [&](Slot s) { return s == 0 ? Bounds{low, high} : Bounds{-1.0, 1.0}; });
  };
  for (const double left : {-1.0, -1e-4, -1e-300})
    expect_bounds(over(left, 2.0), -std::numbers::pi, std::numbers::pi);
  expect_bounds(over(1.0, 2.0), -0.25 * std::numbers::pi, 0.25 * std::numbers::pi);
}

TEST(Interval, DecidesCases) {
  const Expr e = select(less(x, 1.0), x, 10.0);
  expect_bounds(on(e, -1.0, 0.5), -1.0, 0.5);
  expect_bounds(on(e, 1.0, 3.0), 10.0, 10.0);
  expect_bounds(on(e, 0.0, 3.0), 0.0, 10.0);
}

TEST(Interval, FlagsUndefinedAndUnknown) {
  EXPECT_FALSE(on(log(x), -1.0, 2.0).defined);
  EXPECT_TRUE(on(log(x), 1.0, 2.0).defined);
  EXPECT_FALSE(on(1.0 / x, -1.0, 1.0).defined);
  EXPECT_FALSE(on(Expr::make(Op::tan, {x}), 1.0, 2.0).defined);
  EXPECT_FALSE(on(Expr::make(Op::mittag_leffler, {1.5, 1.0, x}), -2.0, 1.0).known);
  EXPECT_TRUE(on(exp(x), 0.0, 1.0).known);
}

TEST(Interval, OfSpecialFunctionsAndTables) {
  for (const double width : {0.1, 1.0, 5.0}) {
    expect_contained(Expr::make(Op::mittag_leffler, {0.6, 0.8, x}), -width, 0.3 * width);
    expect_contained(Expr::make(Op::bessel_j, {1.0, x}), -width, width);
    expect_contained(Expr::make(Op::bessel_j, {-3.0, x}), -width, width);
    expect_contained(Expr::make(Op::erfc, {x}), -width, 3.0 * width);
    for (const double n : {0.0, 1.0, 4.0})
      expect_contained(Expr::make(Op::erfcx, {n, x}), -width, 30.0 * width);
    expect_contained(Expr::make(Op::polygamma, {0.0, x}), 0.2, width + 0.2);
    expect_contained(Expr::make(Op::polygamma, {2.0, x}), 0.2, width + 0.2);
    expect_contained(Expr::make(Op::gamma, {x}), 0.2, width + 0.2);
    expect_contained(pow(x, 0.3), -1.0, width);
    expect_contained(pow(x, -1.7), 0.0, width);
    for (const auto kind : {Table::Interpolation::linear, Table::Interpolation::monotone_cubic}) {
      const auto table = std::make_shared<Table>("f", std::vector{0.0, 0.5, 0.7, 2.0, 4.0},
                                                 std::vector{0.0, 3.0, -1.0, 0.0, 9.0}, kind);
      expect_contained(Expr::tabulated(table, x), 0.1, std::min(width, 4.0));
      expect_contained(Expr::tabulated(table, x, true), 0.1, std::min(width, 4.0));
      expect_contained(Expr::tabulated(table, x), -1.0, width);
    }
  }
}

TEST(Interval, RoundsOutwards) {
  // 0.1 + 0.2 is not 0.3: the exact sum of the two doubles must lie inside.
  const Bounds b = on(x + y, 0.1, 0.1);
  EXPECT_LT(b.low, b.high);
  EXPECT_TRUE(b.contains(0.2));
  const Bounds third = on(1.0 / x, 3.0, 3.0);
  EXPECT_LT(third.low, third.high);
}

/// Next to an overflow rounding outwards must not change a sign: 1/exp(.) and products with it.
TEST(Interval, KeepsSignsWhereExponentialsOverflow) {
  const Expr grows = exp(Expr(1000.0) * x);
  EXPECT_GE(on(Expr(1.0) / (Expr(1.0) + grows), 0.0, 1e9).low, 0.0);
  EXPECT_LE(on(Expr(-1.0) / (Expr(1.0) + grows), 0.0, 1e9).high, 0.0);
  EXPECT_GE(on(x / (Expr(1.0) + grows), 0.0, 1e9).low, 0.0);
  EXPECT_LE(on(-x / (Expr(1.0) + grows), 0.0, 1e9).high, 0.0);
  // the product of two numbers that underflows is not known to be 0
  const Bounds tiny = on(-x * x, 1e-200, 1e-200);
  EXPECT_LT(tiny.low, 0.0);
}

/// exp(a) (c + exp(a))^-n and the like: the same values, and finite bounds where the quotient as
/// written is infinity over infinity.
TEST(Overflow, QuotientsOfExponentialsAreRewritten) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  int finite = 0, open = 0;
  for (int scene = 0; scene < 300; ++scene) {
    const double k = std::pow(10.0, 3.0 * any(random)), a = any(random) - 0.5,
                 c = 0.2 + 2.0 * any(random);
    const Expr u = Expr(k) * (x - Expr(a)), e = exp(u);
    const std::vector<Expr> all{Expr(c) / (Expr(c) + e),
                                e / (Expr(c) + e),
                                x / (Expr(1.0) + e),
                                Expr(2.0) / (exp(u) + exp(-u)),
                                Expr(1.0) / Expr::make(Op::cosh, {u}),
                                x * x / (Expr(c) + e * e)};
    const Expr f = derivative(all[static_cast<std::size_t>(scene) % all.size()], 0);
    const Expr g = without_overflow(f);
    for (int i = 0; i < 20; ++i) {
      const double at = a + (any(random) - 0.5) * 40.0 / k;
      const auto value_of = [&](Slot) { return at; };
      const double expected = evaluate(f, value_of);
      EXPECT_NEAR(evaluate(g, value_of), expected, 1e-10 * (k + std::abs(expected))) << scene;
    }
    const Bounds before = on(f, a + 10.0, 1e6), after = on(g, a + 10.0, 1e6);
    open += !(std::isfinite(before.low) && std::isfinite(before.high));
    finite += std::isfinite(after.low) && std::isfinite(after.high) && after.known;
  }
  EXPECT_EQ(finite, 300);
  EXPECT_GT(open, 100);
  EXPECT_EQ(without_overflow(x * exp(-x)), x * exp(-x)); // nothing to do
}
