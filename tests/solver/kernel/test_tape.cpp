// The tape against Expr::evaluate, which walks the graph node by node: the same bits.
#include "random_expr.hpp"
#include "solver/kernel/table.hpp"
#include "solver/kernel/tape.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <memory>

using namespace hvi::solver;
using namespace hvi::solver::test;

namespace {

const Expr x = Expr::variable(0), y = Expr::variable(1);

bool same_bits(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) ||
         std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

std::vector<double> inputs_of(const Tape& tape, const std::vector<double>& point) {
  std::vector<double> values;
  for (const Slot s : tape.inputs) values.push_back(point[static_cast<std::size_t>(s)]);
  return values;
}

} // namespace

TEST(Tape, GivesTheSameBitsAsTheExpression) {
  RandomTrees random(3, everything);
  TapeWorkspace workspace;
  for (int i = 0; i < 300; ++i) {
    const std::vector<Expr> es{random.tree(5).expr(), random.tree(4).expr()};
    const Tape tape = compile(es);
    const std::size_t n = 1 + static_cast<std::size_t>(random.below(300)); // around the block size
    std::vector<std::vector<double>> points, columns(tape.inputs.size());
    for (std::size_t p = 0; p < n; ++p) {
      points.push_back(random.point());
      const auto values = inputs_of(tape, points.back());
      for (std::size_t k = 0; k < values.size(); ++k) columns[k].push_back(values[k]);
    }
    std::vector<const double*> inputs;
    for (const auto& column : columns) inputs.push_back(column.data());
    std::vector<double> out(2 * n);
    evaluate(tape, inputs, n, out, workspace);
    for (std::size_t p = 0; p < n; ++p)
      for (std::size_t o = 0; o < 2; ++o)
        ASSERT_TRUE(same_bits(out[o * n + p], value_at(es[o], points[p]))) << to_string(es[o]);
    ASSERT_TRUE(same_bits(evaluate_one(tape, inputs_of(tape, points[0]), workspace), out[0]));
  }
}

TEST(Tape, SharesCommonSubexpressions) {
  // Equal parts built apart: sin(x*y) appears three times, as three different nodes.
  const auto part = [] { return sin(Expr::variable(0) * Expr::variable(1)); };
  const std::vector<Expr> es{part() + x, exp(part()), part()};
  const Tape tape = compile(es);
  EXPECT_EQ(tape.code.size(), 6U); // x, y, x*y, sin, +, exp
  EXPECT_EQ(tape.inputs, (std::vector<Slot>{0, 1}));
}

TEST(Tape, BranchesNotTakenMayBeNaN) {
  const std::vector<Expr> e{select(less(x, 0.0), 0.0, sqrt(x) * log(x + 1.0))};
  const Tape tape = compile(e);
  const std::vector<double> points{-4.0, -0.5, 0.0, 4.0};
  const double* input = points.data();
  std::vector<double> out(4);
  TapeWorkspace workspace;
  evaluate(tape, std::span(&input, 1), 4, out, workspace);
  EXPECT_EQ(out[0], 0.0);
  EXPECT_EQ(out[1], 0.0);
  EXPECT_EQ(out[3], 2.0 * std::log(5.0));
}

TEST(Tape, RunsTablesAndSpecialFunctions) {
  const auto table =
      std::make_shared<Table>("f", std::vector{0.0, 1.0, 3.0}, std::vector{1.0, 4.0, 0.0},
                              Table::Interpolation::monotone_cubic);
  const Expr e = Expr::tabulated(table, x) + Expr::tabulated(table, x, true) +
                 Expr::make(Op::mittag_leffler, {0.5, 1.0, -x}) +
                 Expr::make(Op::erfcx, {1.0, 3.0 * x}) + Expr::make(Op::erfc, {x}) +
                 Expr::make(Op::bessel_j, {1.0, x}) + Expr::make(Op::gamma, {x + 1.0});
  const Tape tape = compile(std::span(&e, 1));
  TapeWorkspace workspace;
  for (const double v : {0.0, 0.4, 1.0, 2.2, 3.0, 3.1}) {
    const double got = evaluate_one(tape, std::span(&v, 1), workspace);
    EXPECT_TRUE(same_bits(got, value_at(e, std::vector<double>(4, v)))) << v;
  }
}

TEST(Tape, TakesConstantsAndNoPoints) {
  const std::vector<Expr> es{Expr(2.5), Expr(2.5) + y};
  const Tape tape = compile(es);
  TapeWorkspace workspace;
  const double value = 1.0;
  const double* input = &value;
  evaluate(tape, std::span(&input, 1), 0, {}, workspace);
  std::vector<double> out(2);
  evaluate(tape, std::span(&input, 1), 1, out, workspace);
  EXPECT_EQ(out, (std::vector<double>{2.5, 3.5}));
  EXPECT_THROW(evaluate(tape, {}, 1, out, workspace), std::invalid_argument);
  EXPECT_THROW(evaluate(tape, std::span(&input, 1), 2, out, workspace), std::invalid_argument);
}

TEST(Tape, DoesNotAllocateOnceGrown) {
  const std::vector<Expr> es{exp(x * y) + pow(x, 3.0)};
  const Tape tape = compile(es);
  TapeWorkspace workspace;
  const std::vector<double> point{0.5, 2.0};
  evaluate_one(tape, point, workspace);
  const double* before = workspace.registers.data();
  EXPECT_EQ(evaluate_one(tape, point, workspace), std::exp(1.0) + 0.125);
  EXPECT_EQ(workspace.registers.data(), before);
}
