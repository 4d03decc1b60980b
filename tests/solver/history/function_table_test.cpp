// Tables of expensive functions against the functions, and kernels in batches against single
// values.
#include "solver/history/function_table.hpp"
#include "solver/history/kernel_function.hpp"
#include "solver/kernel/scalar.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace hvi::solver::test {
namespace {

class TableOfMittagLeffler : public testing::TestWithParam<double> {};

TEST_P(TableOfMittagLeffler, AgreesToRoundingAndSavesTheFunction) {
  const double alpha = GetParam();
  int calls = 0;
  FunctionTable table([&](double x) {
    ++calls;
    return mittag_leffler(alpha, 1, x);
  });
  constexpr int points = 20000;
  double worst = 0;
  for (int i = 0; i < points; ++i) {
    const double x = -std::pow(10.0, -4 + 6.0 * i / points);
    const double exact = mittag_leffler(alpha, 1, x);
    worst = std::max(worst, std::abs(table(x) - exact) / std::abs(exact));
  }
  EXPECT_LE(worst, 2e-13) << table.unresolved() << " of " << table.pieces();
  EXPECT_LT(calls, points / 2) << table.unresolved() << " of " << table.pieces();
}

INSTANTIATE_TEST_SUITE_P(Alphas, TableOfMittagLeffler, testing::Values(0.1, 0.3, 0.5, 0.75, 0.9));

TEST(FunctionTable, CallsTheFunctionWhereNoPolynomialServes) {
  FunctionTable table([](double x) { return std::abs(x - 1.3); });
  for (double x = 0.01; x < 100; x *= 1.0007) EXPECT_NEAR(table(x), std::abs(x - 1.3), 1e-12);
  EXPECT_EQ(table.unresolved(), 1U);
  EXPECT_EQ(table(0), 1.3);
  EXPECT_EQ(table(1e30), 1e30 - 1.3);
  EXPECT_TRUE(std::isinf(table(std::numeric_limits<double>::infinity())));
  EXPECT_TRUE(std::isnan(table(std::nan(""))));
}

TEST(FunctionTable, ItsValuesDoNotDependOnTheOrderOfQuestions) {
  const auto f = [](double x) { return std::exp(-x) / (1 + x); };
  FunctionTable one(f), two(f);
  std::vector<double> forth, back;
  for (int i = 1; i < 500; ++i) forth.push_back(one(0.01 * i));
  for (int i = 499; i > 0; --i) back.insert(back.begin(), two(0.01 * i));
  EXPECT_EQ(forth, back);
}

TEST(KernelFunction, BatchesFromTablesAgreeWithSingleValues) {
  const Expr t = Expr::variable(slot::t), lag = Expr::variable(slot::lag);
  const auto relaxation = [](double alpha, const Expr& x) {
    return Expr::make(Op::mittag_leffler, {Expr(alpha), Expr(1.0), x});
  };
  const Expr slow = relaxation(0.5, -sqrt(lag)), other = relaxation(0.8, -t * lag);
  const KernelFunction q(slow * other + t * slow + relaxation(0.7, -slow), {});
  std::vector<double> lags, out(400);
  for (int i = 0; i < 400; ++i) lags.push_back(1e-6 * std::pow(1.04, i));
  q.evaluate(1.5, lags, out);
  for (std::size_t i = 0; i < lags.size(); ++i)
    EXPECT_NEAR(out[i], q(1.5, lags[i]), 1e-13 * std::abs(out[i])) << lags[i];
}

} // namespace
} // namespace hvi::solver::test
