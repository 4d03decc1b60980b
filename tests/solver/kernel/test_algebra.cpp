// Addends, factors, expansion, affine parts and separation: what is taken apart gives the whole.
#include "random_expr.hpp"
#include "solver/kernel/algebra.hpp"

#include <gtest/gtest.h>

using namespace hvi::solver;
using namespace hvi::solver::test;

namespace {

const Expr x = Expr::variable(0), y = Expr::variable(1), t = Expr::variable(slot::t),
           s = Expr::variable(slot::lag);

bool is_time(Slot slot) { return slot == slot::t || slot == slot::lag; }

Expr whole(const Separated& terms) {
  Expr sum = 0.0;
  for (const auto& [f, g] : terms) sum = sum + f * g;
  return sum;
}

/// Splits, checks that the groups are pure and that the sum of the terms has e's values.
Separated check_split(const Expr& e) {
  const auto terms = split_separable(e, is_time);
  EXPECT_TRUE(terms.has_value()) << to_string(e);
  if (!terms) return {};
  for (const auto& [f, g] : *terms) {
    for (const Slot k : f.slots()) EXPECT_FALSE(is_time(k)) << to_string(f);
    for (const Slot k : g.slots()) EXPECT_TRUE(is_time(k)) << to_string(g);
  }
  RandomTrees random(9, arithmetic, 5);
  const Expr sum = whole(*terms);
  for (int i = 0; i < 50; ++i) {
    auto p = random.point();
    p[slot::lag] = std::abs(p[slot::lag]);
    const double want = value_at(e, p);
    if (std::isnan(want)) continue;
    EXPECT_NEAR(value_at(sum, p), want, 1e-12 * (1.0 + std::abs(want))) << to_string(e);
  }
  return *terms;
}

} // namespace

Expr product_of(const std::vector<Expr>& terms) {
  Expr total = 1.0;
  for (const Expr& term : terms) total = total * term;
  return total;
}

TEST(Algebra, AddendsAndFactors) {
  const std::vector<Expr> parts = addends(x - (y - t)), want{x, -y, t};
  EXPECT_TRUE(std::ranges::is_permutation(parts, want));
  EXPECT_TRUE(addends(0.0).empty());
  EXPECT_EQ(expand(product_of(factors(-x * y / (t * s)))), expand(-x * y / (t * s)));
  EXPECT_EQ(factors(2.0 * x / t).size(), 3U);
  EXPECT_EQ(factors(pow(x * y, 2.0)).size(), 2U);
  EXPECT_TRUE(factors(1.0).empty());
}

TEST(Algebra, PartsGiveTheWhole) {
  RandomTrees random(21, arithmetic);
  for (int i = 0; i < 3000; ++i) {
    const Expr e = random.tree(4).expr();
    const auto p = random.point();
    const double want = value_at(e, p);
    if (!(std::abs(want) < 1e6)) continue;
    EXPECT_NEAR(value_at(sum_of(addends(e)), p), want, 1e-9 * (1.0 + std::abs(want)));
    EXPECT_NEAR(value_at(product_of(factors(e)), p), want, 1e-9 * (1.0 + std::abs(want)));
  }
}

TEST(Algebra, ExpandKeepsTheValue) {
  RandomTrees random(22, arithmetic);
  int compared = 0;
  for (int i = 0; i < 4000; ++i) {
    const Tree tree = random.tree(4);
    const Expr expanded = expand(tree.expr());
    const auto p = random.point();
    double size = 1.0;
    const double want = tree.evaluate(p, size);
    if (size > 1e3) continue;
    ++compared;
    double magnitude = size; // of the expanded terms: their cancellation is not an error
    for (const Expr& term : addends(expanded))
      magnitude = std::max(magnitude, std::abs(value_at(term, p)));
    EXPECT_NEAR(value_at(expanded, p), want, 1e-8 * magnitude)
        << to_string(tree.expr()) << "   expanded: " << to_string(expanded);
  }
  EXPECT_GT(compared, 1500);
}

TEST(Algebra, ExpandFindsTheNormalForm) {
  EXPECT_EQ(expand((x + y) * (x - y)), expand(x * x - y * y));
  EXPECT_TRUE(
      expand(pow(x + y, 3.0) - x * x * x - 3.0 * x * x * y - 3.0 * x * y * y - y * y * y).is(0.0));
  EXPECT_EQ(expand((x + y) / t), expand(x / t + y / t));
  EXPECT_EQ(expand(x * (y / x)), y);
  EXPECT_EQ(expand(sqrt(s) * sqrt(s)), s);
  const Expr frozen = exp(x + y);
  EXPECT_EQ(expand(frozen), frozen);
}

TEST(Algebra, ExpandDoesNotExplode) {
  Expr product = 1.0;
  for (int i = 0; i < 40; ++i) product = product * (Expr::variable(100 + i) + x);
  EXPECT_LE(addends(expand(product)).size(), 4000U);
}

TEST(Algebra, FindsAffineParts) {
  const auto found = affine_in(y * (t - 2.0 * x) / 3.0 + t, 0);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->first.depends_on(0) || found->second.depends_on(0));
  const std::vector<double> p{0.7, 1.3, -0.2, 0.9};
  EXPECT_NEAR(value_at(found->first + found->second * x, p),
              value_at(y * (t - 2.0 * x) / 3.0 + t, p), 1e-14);
  ASSERT_TRUE(affine_in(pow(1.0 + x, 2.0) - x * x, 0));
  EXPECT_TRUE(affine_in(pow(1.0 + x, 2.0) - x * x, 0)->second.is(2.0));
  EXPECT_TRUE(affine_in(select(less(y, 0.0), x, 2.0 * x + 1.0), 0));
  for (const Expr& e : {x * x, sin(x), abs(x), Expr::make(Op::sign, {x}), 1.0 / x,
                        select(less(x, 0.0), x, 2.0 * x), max(x, 0.0)})
    EXPECT_FALSE(affine_in(e, 0)) << to_string(e);
}

TEST(Separate, Products) {
  EXPECT_EQ(check_split(2.0 * x * t).size(), 1U);
  EXPECT_EQ(check_split((x + y) * exp(-t)).size(), 1U);
  EXPECT_EQ(check_split((x + t) * (y - t)).size(), 3U);
  EXPECT_EQ(check_split(x / (t * t + 1.0)).size(), 1U);
  EXPECT_EQ(check_split(pow(x + t, 3.0)).size(), 4U);
  EXPECT_EQ(split_separable(pow(x + t, 12.0), is_time)->size(), 13U); // more would cancel
  EXPECT_TRUE(check_split(0.0).empty());
  EXPECT_EQ(check_split(3.0).size(), 1U);
}

TEST(Separate, MergesEqualParts) {
  // One tensor with a Prony series: one term, not three.
  const Expr series = 0.5 + 0.3 * exp(-s) + 0.2 * exp(-s / 7.0);
  EXPECT_EQ(
      check_split((1.0 + x) * 0.5 + (1.0 + x) * 0.3 * exp(-s) + (2.0 + 2.0 * x) * exp(-2.0 * s))
          .size(),
      2U);
  EXPECT_EQ(check_split((x * y) * series).size(), 1U);
  EXPECT_EQ(check_split(x * exp(-s) + y * (2.0 * exp(-s))).size(), 1U);
  EXPECT_TRUE(check_split(x * t - t * x).empty());
}

TEST(Separate, Functions) {
  EXPECT_EQ(check_split(exp(x - 2.0 * t + 1.0)).size(), 1U);
  EXPECT_EQ(check_split(sin(x - 3.0 * t)).size(), 2U);
  EXPECT_EQ(check_split(cos(2.0 * t + x * y)).size(), 2U);
  EXPECT_EQ(check_split(abs(x * t)).size(), 1U);
  EXPECT_EQ(check_split(pow(2.0, x + t)).size(), 1U);
  EXPECT_EQ(check_split(sqrt(exp(x) * s)).size(), 1U);
  EXPECT_EQ(check_split(pow(3.0 * s * abs(x), -0.5)).size(), 1U);
  EXPECT_EQ(check_split(log(exp(x) * (1.0 + s))).size(), 2U);
}

TEST(Separate, Cases) {
  check_split(select(less(t, 1.0), x * t, y));
  check_split(select(less(x, 0.5), t, x + t * y));
  check_split(select(Expr::make(Op::logic_and, {less(t, 1.0), less(x, 0.0)}), x * t, y * t));
  check_split(select(Expr::make(Op::logic_or, {less(t, 1.0), less(x, 0.0)}), x, y + t));
  check_split(select(less(0.0, t), x * log(t), 0.0)); // the masked logarithm is NaN for t < 0
  EXPECT_EQ(check_split(select(less(t, 1.0), x, 2.0 * x)).size(), 1U);
}

TEST(Separate, SaysNoWhenItCannot) {
  for (const Expr& e : {exp(x * t), sin(x * t), 1.0 / (x + t), sqrt(x + t), max(x, t),
                        select(less(x, t), x, t), pow(x * t, 0.5), pow(x, t), pow(x + t, 13.0)})
    EXPECT_FALSE(split_separable(e, is_time)) << to_string(e);
}

TEST(Separate, SumsOfRandomProducts) {
  RandomTrees random(31, arithmetic, 5);
  for (int i = 0; i < 300; ++i) {
    Expr e = 0.0;
    for (int k = random.below(4); k >= 0; --k) {
      const std::pair<Slot, Expr> to_time[]{{0, t}, {1, s}, {2, t * s}};
      const std::pair<Slot, Expr> to_space[]{{3, x}, {4, y}};
      const Expr g = substitute(random.tree(2).expr(), to_time);
      e = e + substitute(random.tree(2).expr(), to_space) * g;
    }
    const auto terms = split_separable(e, is_time);
    ASSERT_TRUE(terms) << to_string(e);
    const auto p = random.point();
    const double want = value_at(e, p), got = value_at(whole(*terms), p);
    if (!(std::abs(want) < 1e4)) continue;
    EXPECT_NEAR(got, want, 1e-7 * (1.0 + std::abs(want))) << to_string(e);
  }
}
