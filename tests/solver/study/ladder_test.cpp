// Ladders, orders and fronts against what they are by hand.
#include "solver/study/ladder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace hvi::solver {
namespace {

TEST(Ladder, CombinesEveryRungWithEveryOther) {
  const std::vector<int> rungs = {2, 3};
  const auto all = combinations(rungs);
  ASSERT_EQ(all.size(), 6U);
  EXPECT_EQ(all.front(), (std::vector<int>{0, 0}));
  EXPECT_EQ(all[1], (std::vector<int>{0, 1}));
  EXPECT_EQ(all.back(), (std::vector<int>{1, 2}));
}

TEST(Ladder, OrderOfAnErrorThatFallsByFour) {
  EXPECT_DOUBLE_EQ(*observed_order(4e-3, 1e-3, 2.0), 2.0);
  EXPECT_FALSE(observed_order(0.0, 1e-3, 2.0));
  EXPECT_FALSE(observed_order(1e-3, 1e-3, 1.0));
}

TEST(Ladder, TheFrontIsWhatNothingBeatsInBoth) {
  const std::vector<double> cost = {1, 2, 3, 4, 5}, error = {9, 5, 6, std::nan(""), 1};
  EXPECT_EQ(pareto_front(cost, error), (std::vector<bool>{true, true, false, false, true}));
}

/// Analytic: errors c s^-p of either kind are found from their distances.
TEST(Ladder, RichardsonFindsOrderAndErrors) {
  for (const double power : {1.0, 2.0})
    for (const double p : {0.8, 1.0, 2.0}) {
      const double finest = 3e-4;
      std::vector<double> scales = {0.125, 0.25, 0.5}, distances;
      for (const double s : scales)
        distances.push_back(finest * std::pow(std::pow(s, -p * power) - 1.0, 1.0 / power));
      const auto fit = richardson(scales, distances);
      ASSERT_TRUE(fit);
      EXPECT_NEAR(fit->order, p, 1e-12);
      EXPECT_NEAR(fit->errors.back(), finest, 1e-9);
      EXPECT_NEAR(fit->errors.front(), finest * std::pow(8.0, p), 1e-9);
    }
  const std::vector<double> one = {0.5};
  EXPECT_FALSE(richardson(one, one));
}

} // namespace
} // namespace hvi::solver
