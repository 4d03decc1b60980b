// Prony sums through data: data that are such sums, noise, signs.
#include "solver/kernel/prony_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace hvi::solver {
namespace {

template <class F>
Table table_of(F f, double step, int count) {
  std::vector<double> x, y;
  for (int i = 0; i < count; ++i) {
    x.push_back(step * i);
    y.push_back(f(x.back()));
  }
  return Table("data", x, y, Table::Interpolation::linear);
}

/// Analytic: the data come from a sum whose times are not on the grid of times. Two neighbours on
/// it, a factor r = 10^(1/20) apart, replace one between them within (log r)^2 / 8 * 4 / e^2 = 9e-4
/// of its weight; least squares do better.
TEST(PronyFit, FollowsASumOfExponentials) {
  const auto f = [](double x) { return 0.4 + 0.5 * std::exp(-x / 0.37) + 0.1 * std::exp(-x / 2); };
  const auto fit = fit_prony(table_of(f, 0.05, 80));
  EXPECT_LT(fit.largest, 2e-4);
  EXPECT_LE(fit.mean, fit.largest);
  for (double x = 0.025; x < 3.9; x += 0.05) EXPECT_NEAR(fit.series.value(x), f(x), 2e-4);
  EXPECT_LT(fit.series.weights.size(), 10u);
}

TEST(PronyFit, WeightsHaveTheSignOfTheData) {
  const auto fit = fit_prony(table_of([](double x) { return -std::exp(-std::sqrt(x)); }, 0.1, 50));
  EXPECT_LT(fit.largest, 2e-2);
  for (const double w : fit.series.weights) EXPECT_LT(w, 0);
  EXPECT_LE(fit.series.constant, 0);
}

/// Errors are those of the largest value, whatever the unit is.
TEST(PronyFit, DoesNotDependOnTheUnit) {
  const auto in_unit = [](double unit) {
    return fit_prony(table_of([=](double x) { return unit * std::exp(-std::sqrt(x)); }, 0.1, 50));
  };
  const auto one = in_unit(1.0), other = in_unit(4096.0);
  EXPECT_NEAR(other.largest / one.largest, 1.0, 1e-9);
  EXPECT_NEAR(other.mean / one.mean, 1.0, 1e-9);
  EXPECT_EQ(other.series.times, one.series.times);
}

/// Noise of 1 % is not followed: the error that is reported is about the noise.
TEST(PronyFit, DoesNotFollowNoise) {
  unsigned state = 1;
  const auto noise = [&] {
    state = state * 1664525u + 1013904223u;
    return 0.01 * (static_cast<double>(state >> 8) / 8388608.0 - 1.0);
  };
  const auto f = [](double x) { return std::exp(-x) + 0.5; };
  const auto fit = fit_prony(table_of([&](double x) { return f(x) + noise(); }, 0.02, 200));
  EXPECT_GT(fit.mean, 0.002);
  EXPECT_LT(fit.mean, 0.006);
  for (double x = 0.2; x < 3.5; x += 0.1) EXPECT_NEAR(fit.series.value(x), f(x), 0.005) << x;
}

/// Of a long table every so many points are fitted; a point that is left out still counts in the
/// error: the outlier at an odd index is half the largest value off the fit.
TEST(PronyFit, LongTablesAreJudgedAtAllPoints) {
  const auto smooth = [](double x) { return std::exp(-x / 30); };
  const auto clean = fit_prony(table_of(smooth, 0.01, 6000));
  EXPECT_LT(clean.largest, 2e-3);
  const auto spiked = fit_prony(
      table_of([&](double x) { return std::abs(x - 0.01) < 1e-9 ? 0.5 : smooth(x); }, 0.01, 6000));
  EXPECT_EQ(spiked.series.weights, clean.series.weights);
  EXPECT_NEAR(spiked.largest, 0.5, 2e-3);
}

/// A growing function is no relaxation: the best sum is the constant, and its error says so.
TEST(PronyFit, ReportsTheErrorOfDataThatDoNotRelax) {
  const auto fit = fit_prony(table_of([](double x) { return x; }, 0.1, 11));
  EXPECT_GT(fit.largest, 0.3);
}

} // namespace
} // namespace hvi::solver
