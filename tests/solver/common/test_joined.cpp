// Lists of texts and numbers, and points with few digits.
#include "solver/common/joined.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

namespace hvi::solver {
namespace {

TEST(Joined, Texts) {
  EXPECT_EQ(joined(std::vector<std::string>{}), "");
  EXPECT_EQ(joined(std::vector<std::string>{"", "b"}), ", b") << "an empty text is one of them";
  EXPECT_EQ(joined(std::array{"a", "b", "c"}, " and "), "a and b and c");
}

TEST(Joined, NumbersHaveAllTheirDigits) {
  EXPECT_EQ(joined(std::vector{0.1, 1.0 / 3.0}), "0.1, 0.3333333333333333");
  EXPECT_EQ(joined(std::array{3, 4}), "3, 4");
}

TEST(Joined, PointsHaveAsManyDigitsAsTheyAreGiven) {
  EXPECT_EQ(joined(std::array{1.0 / 3.0, 2.0, 9.0}, 2, 4), "0.3333, 2");
}

} // namespace
} // namespace hvi::solver
