// Building, simplifying and printing expressions.
#include "solver/kernel/expr.hpp"

#include <gtest/gtest.h>

using namespace hvi::solver;

namespace {
const Expr x = Expr::variable(slot::x(0)), y = Expr::variable(slot::x(1)),
           t = Expr::variable(slot::t);
} // namespace

TEST(Expr, SimplifiesAsItIsBuilt) {
  EXPECT_TRUE((x - x).is(0.0));
  EXPECT_EQ(x + y, y + x);
  EXPECT_EQ(2.0 * x - x, x);
}
