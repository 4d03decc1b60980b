// How the precision of a correction is chosen.
#include "solver/linear/mixed/precision_choice.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

namespace hvi::solver {
namespace {

constexpr double asked = 1e-10;
const double unpredicted = std::numeric_limits<double>::infinity();

TEST(PrecisionChoice, IsFullUntilAStepWasPredicted) {
  PrecisionChoice choice(asked);
  choice.note_moved(unpredicted);
  EXPECT_FALSE(choice.worthwhile(100));
  EXPECT_EQ(choice.limits(true).forward, FactorPrecision::full);
  EXPECT_EQ(choice.limits(true).back(1e-9), FactorPrecision::full);
  choice.note_moved(1e-3);
  EXPECT_TRUE(choice.worthwhile(24));
  EXPECT_FALSE(choice.worthwhile(23));
  const auto limits = choice.limits(true);
  EXPECT_EQ(limits.forward, FactorPrecision::single);
  EXPECT_EQ(limits.back(1e-6), FactorPrecision::single);
  EXPECT_EQ(limits.back(1e-2), FactorPrecision::fine);
  EXPECT_EQ(limits.back(2.0), FactorPrecision::full);
}

// The larger the error of a rounded backward solve, the less contact unknowns may move in the next.
TEST(PrecisionChoice, LearnsFromTheErrorsLeft) {
  PrecisionChoice choice(asked);
  choice.note_moved(1e-4);
  const double before = choice.limits(true).most_single;
  choice.learn(FactorPrecision::single, FactorPrecision::single, 2 * choice.target());
  EXPECT_LT(choice.limits(true).most_single, before);
  EXPECT_DOUBLE_EQ(choice.limits(true).most_single, 1e-4 / 4);
  EXPECT_EQ(choice.limits(true).back(1e-4), FactorPrecision::fine);
  // Back with 48 bits and still too much: the forward solve is to blame, the first time.
  choice.learn(FactorPrecision::single, FactorPrecision::fine, 2 * choice.target());
  EXPECT_EQ(choice.limits(true).forward, FactorPrecision::fine);
  EXPECT_FALSE(choice.failed());
  for (int k = 0; k < 4; ++k)
    choice.learn(FactorPrecision::fine, FactorPrecision::fine, 2 * choice.target());
  EXPECT_LT(choice.limits(true).most_fine, 1e-3);
  EXPECT_TRUE(choice.failed());
  EXPECT_FALSE(choice.worthwhile(100));
}

TEST(PrecisionChoice, GoesOnFromASavedOne) {
  PrecisionChoice choice(asked), again(asked);
  choice.note_moved(1e-4);
  choice.learn(FactorPrecision::single, FactorPrecision::single, 1e-11);
  choice.learn(FactorPrecision::single, FactorPrecision::fine, 1e-11);
  choice.learn(FactorPrecision::fine, FactorPrecision::fine, 1e-11);
  std::stringstream saved;
  choice.save(saved);
  again.restore(saved);
  EXPECT_EQ(again.limits(true).forward, choice.limits(true).forward);
  EXPECT_EQ(again.limits(true).most_single, choice.limits(true).most_single);
  EXPECT_EQ(again.limits(true).most_fine, choice.limits(true).most_fine);
}

} // namespace
} // namespace hvi::solver
