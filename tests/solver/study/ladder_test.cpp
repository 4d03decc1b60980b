// Ladders, orders and fronts against what they are by hand.
#include "solver/study/ladder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <utility>
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

/// Between all runs of a ladder, of errors with these parts.
std::vector<RungDistance> distances_of(const std::vector<double>& scales, double p, double a,
                                       double b) {
  std::vector<RungDistance> out;
  for (std::size_t i = 0; i < scales.size(); ++i)
    for (std::size_t j = i + 1; j < scales.size(); ++j) {
      const double x = std::pow(scales[i], -p), y = std::pow(scales[j], -p);
      out.push_back({scales[i], scales[j], std::hypot(a * std::sqrt(x * x - y * y), b * (x - y))});
    }
  return out;
}

/// Analytic: three runs tell the order and the error of the finest one, whatever its parts are.
TEST(Ladder, RichardsonFindsOrderAndErrors) {
  for (const auto& scales :
       {std::vector<double>{0.25, 0.5, 1.0}, {0.2, 0.6, 1.0}, {0.125, 0.25, 0.5, 1.0}})
    for (const auto& [a, b] : {std::pair(3e-4, 0.0), {0.0, 3e-4}, {3e-4, 1e-4}, {1e-4, 4e-4}})
      for (double p = 0.4; p < 3.0; p += 0.3071) {
        const auto fit = richardson(distances_of(scales, p, a, b), Measured::norm);
        ASSERT_TRUE(fit);
        const double finest = std::hypot(a, b);
        EXPECT_NEAR(fit->order, p, 1e-3);
        EXPECT_NEAR(fit->finest, finest, 2e-3 * finest) << a << " " << b << " " << p;
        const double coarsest = distances_of({scales.front(), 1.0}, p, a, b)[0].distance;
        const double error = finest * std::pow(scales.front(), -p);
        EXPECT_NEAR(fit->error(coarsest), error, 0.05 * error);
      }
}

/// Analytic: numbers have one direction, so two distances are enough for them, and not for norms.
TEST(Ladder, RichardsonOfNumbersNeedsTwoDistances) {
  const std::vector<RungDistance> two = {{0.25, 1.0, 3.0}, {0.5, 1.0, 1.0}};
  const auto fit = richardson(two, Measured::number);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->order, 1.0, 1e-4);
  EXPECT_NEAR(fit->finest, 1.0, 1e-3);
  EXPECT_NEAR(fit->error(3.0), 4.0, 1e-3);
  EXPECT_FALSE(richardson(two, Measured::norm));
  EXPECT_FALSE(richardson(std::span(two).first(1), Measured::number));
}

/// Distances that grow, such that fall by less than errors can, and such that belong to no ladder.
TEST(Ladder, RichardsonSeesNoOrder) {
  using Distances = std::vector<RungDistance>;
  for (const Distances& no :
       {Distances{{0.25, 1.0, 1.0}, {0.5, 1.0, 1.1}}, {{0.25, 1.0, 1.9}, {0.5, 1.0, 1.0}}})
    EXPECT_FALSE(richardson(no, Measured::number));
  EXPECT_FALSE(
      richardson(Distances{{0.25, 1.0, 1.0}, {0.5, 1.0, 1.0}, {0.25, 0.5, 3.0}}, Measured::norm));
}

} // namespace
} // namespace hvi::solver
