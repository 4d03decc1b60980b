// The estimate of the seconds a run still takes.
#include "lang/cli/time_left.hpp"

#include <gtest/gtest.h>

namespace hvi::lang {
namespace {

/// Seconds for n steps where step i takes a + b i.
double taken(int n, double a, double b) { return a * n + b * n * (n + 1) / 2.0; }

TEST(TimeLeft, IsExactForStepsThatGetSlowerEvenly) {
  TimeLeft left;
  for (int n = 1; n <= 40; ++n) left.note(n, taken(n, 0.5, 0.25));
  EXPECT_NEAR(left.estimate(100), taken(100, 0.5, 0.25) - taken(40, 0.5, 0.25), 1e-9);
}

TEST(TimeLeft, OfEqualStepsIsTheirNumber) {
  TimeLeft left;
  EXPECT_EQ(left.estimate(10), 0.0);
  left.note(1, 2.0);
  EXPECT_DOUBLE_EQ(left.estimate(10), 18.0);
  left.note(5, 10.0); // steps in between were not noted
  EXPECT_DOUBLE_EQ(left.estimate(10), 10.0);
  EXPECT_EQ(left.estimate(5), 0.0);
}

// A slow start does not promise that the rest takes no time.
TEST(TimeLeft, DoesNotFallBelowTheLaterSteps) {
  TimeLeft left;
  left.note(5, 50.0);
  left.note(10, 55.0);
  EXPECT_DOUBLE_EQ(left.estimate(20), 10.0);
}

} // namespace
} // namespace hvi::lang
