// Expressions as bytes: what comes out is what went in, node by node.
#include "solver/kernel/expr_stream.hpp"
#include "solver/kernel/table.hpp"
#include "tests/solver/kernel/random_expr.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <sstream>

namespace hvi::solver {
namespace {

std::string bytes_of(std::span<const Expr> expressions) {
  std::ostringstream out;
  StateWriter w(out);
  put_expressions(w, expressions);
  return std::move(out).str();
}

std::vector<Expr> expressions_in(const std::string& bytes) {
  std::istringstream in(bytes);
  StateReader r(in, {});
  return get_expressions(r);
}

TEST(ExpressionStream, KeepsEveryTree) {
  test::RandomTrees random(7, test::everything);
  std::vector<Expr> all;
  for (int k = 0; k < 300; ++k) all.push_back(random.tree(5).expr());
  const auto back = expressions_in(bytes_of(all));
  ASSERT_EQ(back.size(), all.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(back[k], all[k]) << to_string(all[k]);
    EXPECT_EQ(back[k].hash(), all[k].hash());
    EXPECT_TRUE(std::ranges::equal(back[k].slots(), all[k].slots()));
  }
}

TEST(ExpressionStream, WritesWhatIsSharedOnce) {
  Expr e = Expr::variable(slot::x(0));
  for (int k = 0; k < 60; ++k) e = sin(e) * e; // 2^60 leaves when written out
  const std::string bytes = bytes_of(std::span(&e, 1));
  EXPECT_LT(bytes.size(), 10000u);
  EXPECT_EQ(expressions_in(bytes).front().hash(), e.hash());
}

TEST(ExpressionStream, TablesKeepTheirNumbersAndAreOne) {
  const auto table =
      std::make_shared<const Table>("rise", std::vector{0.0, 1.0, 3.0}, std::vector{2.0, 5.0, 1.0},
                                    Table::Interpolation::monotone_cubic);
  const Expr x = Expr::variable(slot::x(1));
  const std::vector<Expr> all{Expr::tabulated(table, x), Expr::tabulated(table, x, true) + 1.0};
  const auto back = expressions_in(bytes_of(all));
  const auto at = [](double value) { return [value](Slot) { return value; }; };
  for (const double value : {0.0, 0.3, 1.7, 3.0})
    for (std::size_t k = 0; k < all.size(); ++k)
      EXPECT_EQ(evaluate(back[k], at(value)), evaluate(all[k], at(value)));
  EXPECT_EQ(back[0].table(), back[1].args()[0].op() == Op::table_slope ? back[1].args()[0].table()
                                                                       : back[1].args()[1].table());
}

TEST(ExpressionStream, RefusesBrokenBytes) {
  const Expr e = sin(Expr::variable(slot::x(0))) + 2.0;
  std::string bytes = bytes_of(std::span(&e, 1));
  EXPECT_THROW(expressions_in(bytes.substr(0, bytes.size() - 3)), Failure);
  bytes[4] = '\x7f'; // no operation
  EXPECT_THROW(expressions_in(bytes), Failure);
}

} // namespace
} // namespace hvi::solver
