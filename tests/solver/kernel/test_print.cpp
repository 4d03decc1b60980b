// Expressions in the language's notation.
#include "solver/kernel/expr.hpp"
#include "solver/kernel/table.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

using namespace hvi::solver;

namespace {
const Expr x = Expr::variable(slot::x(0)), y = Expr::variable(slot::x(1)),
           t = Expr::variable(slot::t), r = Expr::variable(slot::argument(0));
} // namespace

TEST(Print, UsesFewParentheses) {
  EXPECT_EQ(to_string(x + y), "x + y");
  EXPECT_EQ(to_string(x - y), "x - y");
  EXPECT_EQ(to_string((x + y) * t), "(x + y) * t");
  EXPECT_EQ(to_string(2.0 * x * y), "2 * x * y");
  EXPECT_EQ(to_string(x / (y * t)), "x / (y * t)");
  EXPECT_EQ(to_string(-(x + y)), "-(x + y)");
  EXPECT_EQ(to_string(-(x * y)), "-x * y");
  EXPECT_EQ(to_string(t - 2.0 * x), "t - 2 * x");
  EXPECT_EQ(to_string(t - x / y), "t - x / y");
  EXPECT_EQ(to_string(x - (y - t)), "x - (y - t)");
}

TEST(Print, WritesPowers) {
  EXPECT_EQ(to_string(x * x), "x^2");
  EXPECT_EQ(to_string(-pow(x, 2.0)), "-x^2");
  EXPECT_EQ(to_string(pow(-2.0, x)), "(-2)^x");
  EXPECT_EQ(to_string(pow(x, -0.5)), "x^-0.5");
  EXPECT_EQ(to_string(pow(x + y, t)), "(x + y)^t");
  EXPECT_EQ(to_string(pow(pow(x, y), t)), "(x^y)^t");
  EXPECT_EQ(to_string(pow(x, y * t)), "x^(y * t)");
}

TEST(Print, WritesCases) {
  const Expr inner = select(less_equal(r, 1.0), 2.0 * r, exp(r));
  EXPECT_EQ(to_string(inner), "| r <= 1 -> 2 * r | otherwise -> exp(r)");
  EXPECT_EQ(to_string(select(less(r, 0.0), 0.0, inner)),
            "| r < 0 -> 0 | r <= 1 -> 2 * r | otherwise -> exp(r)");
  EXPECT_EQ(to_string(inner + 1.0), "(| r <= 1 -> 2 * r | otherwise -> exp(r)) + 1");
  EXPECT_EQ(to_string(less(x, y) * t), "(| x < y -> 1 | otherwise -> 0) * t");
  EXPECT_EQ(to_string(select(x, y, t)), "| x != 0 -> y | otherwise -> t");
}

TEST(Print, WritesConditions) {
  const Expr a = less(x, y), b = less(y, t), c = Expr::make(Op::equal, {x, t});
  const auto both = [](Op op, const Expr& p, const Expr& q) { return Expr::make(op, {p, q}); };
  const Expr e = select(both(Op::logic_and, both(Op::logic_or, a, b), c), x, y);
  EXPECT_TRUE(to_string(e) == "| (x < y or y < t) and x == t -> x | otherwise -> y" ||
              to_string(e) == "| (y < t or x < y) and x == t -> x | otherwise -> y")
      << to_string(e);
  EXPECT_EQ(to_string(select(both(Op::logic_and, Expr::make(Op::logic_not, {c}), x), x, y)),
            "| x != t and x != 0 -> x | otherwise -> y");
}

TEST(Print, NamesSlots) {
  const auto name = [](Slot s) { return to_string(Expr::variable(s)); };
  EXPECT_EQ(name(slot::x(2)), "z");
  EXPECT_EQ(name(slot::lag), "lag");
  EXPECT_EQ(name(slot::normal(1)), "nu[1]");
  EXPECT_EQ(name(slot::argument(2)), "arg[2]");
  EXPECT_EQ(name(slot::test(slot::value(1))), "v[1]");
  EXPECT_EQ(name(slot::test(slot::gradient(0, 2))), "grad(v)[0, 2]");
  EXPECT_EQ(name(slot::field(3, slot::gradient(2, 1))), "grad(field[3])[2, 1]");
  EXPECT_EQ(name(slot::multiplier(2, 1)), "xi[2][1]");
}

TEST(Print, WritesCallsAndTables) {
  const auto table = std::make_shared<Table>("soil", std::vector{0.0, 1.0}, std::vector{0.0, 2.0},
                                             Table::Interpolation::linear);
  EXPECT_EQ(to_string(Expr::tabulated(table, x + y)), "soil(x + y)");
  EXPECT_EQ(to_string(derivative(Expr::tabulated(table, x), 0)), "soil'(x)");
  EXPECT_EQ(to_string(Expr::make(Op::mittag_leffler, {0.5, 1.0, -t})),
            "mittag_leffler(0.5, 1, -t)");
  EXPECT_EQ(to_string(Expr::make(Op::erfcx, {0.0, x + y})), "erfcx(x + y)");
  EXPECT_EQ(to_string(Expr::make(Op::erfcx, {2.0, x})), "erfcx(2, x)");
  EXPECT_EQ(to_string(max(0.0, x)), "max(x, 0)");
}

TEST(Print, NumbersKeepAllDigits) {
  for (const double v : {0.1, 1.0 / 3.0, 1e-300, 6.02214076e23, 123456789.0, 5e-324})
    EXPECT_EQ(std::strtod(to_string(Expr(v)).c_str(), nullptr), v);
}
