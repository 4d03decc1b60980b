// Polynomial degrees of integrands, by hand (analytic).
#include "solver/assembly/degree.hpp"
#include "tests/solver/fem/meshes.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

using namespace test;

TEST(Degree, OfExpressions) {
  const Expr u = Expr::variable(slot::field(0, slot::value(0))),
             du = Expr::variable(slot::field(2, slot::gradient(1, 0))),
             n = Expr::variable(slot::normal(0)), part = Expr::variable(slot::inside(3));
  const Expr sine_t = Expr::make(Op::sin, {t}), sine_x = Expr::make(Op::sin, {x});
  EXPECT_EQ(polynomial_degree(Expr(3.0), 1), 0);
  EXPECT_EQ(polynomial_degree(x * x * y + z, 1), 3);
  EXPECT_EQ(polynomial_degree(u * u + x, 2), 4);
  EXPECT_EQ(polynomial_degree(du * x, 1), 1);
  EXPECT_EQ(polynomial_degree(du * x, 2), 2);
  EXPECT_EQ(polynomial_degree(sine_t * n * part, 2), 0);
  EXPECT_EQ(polynomial_degree(sqrt(abs(du)), 1), 0) << "any function of a constant";
  EXPECT_EQ(polynomial_degree(pow(x + y, Expr(3.0)), 1), 3);
  EXPECT_EQ(polynomial_degree(x / (Expr(2.0) + t), 1), 1);
  EXPECT_EQ(polynomial_degree(select(less(t, Expr(1.0)), x * y, x), 1), 2);
  EXPECT_EQ(polynomial_degree(select(less(t, Expr(1.0)), x, x * y), 1), 2);
  for (const Expr& e : {sine_x, Expr(1.0) / x, sqrt(x), pow(x, t), abs(u), max(x, y),
                        select(less(x, y), x, y), pow(x, Expr(-2.0)), pow(x, Expr(0.5))}) {
    EXPECT_FALSE(polynomial_degree(e, 1).has_value()) << to_string(e);
  }
}

TEST(Degree, OfRules) {
  EXPECT_EQ(exact_degree(x * x, 2, 1), 4);
  EXPECT_EQ(exact_degree(exp(x), 2, 1), 4) << "2 (order + 1)";
  EXPECT_EQ(exact_degree(exp(x), 2, 2), 6);
  EXPECT_EQ(exact_degree(pow(x, Expr(20.0)), 2, 1), 22);
  EXPECT_EQ(exact_degree(pow(x, Expr(40.0)), 2, 2), 30) << "too high to be integrated exactly";
}

} // namespace
} // namespace hvi::solver
