// Tables: interpolation against Boost's PCHIP and by properties; reading of CSV.
#include "solver/kernel/table.hpp"

// Boost 1.74's header below uses the C name of isnan without including it.
// clang-format off
#include <math.h>
// clang-format on

#include <boost/math/interpolators/pchip.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

using namespace hvi::solver;
using Kind = Table::Interpolation;

namespace {

std::string error_of(const std::string& text) {
  try {
    parse_table("f", text, Kind::linear);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "no error";
}

} // namespace

TEST(Table, MonotoneCubicIsPchip) { // independent; the end slopes are another choice there
  const std::vector<double> x{0.0, 1.0, 1.5, 3.0, 4.0, 6.0}, y{0.0, 1.0, 3.0, 3.2, 2.0, -1.0};
  const Table table("f", x, y, Kind::monotone_cubic);
  auto xs = x, ys = y;
  const boost::math::interpolators::pchip<std::vector<double>> other(std::move(xs), std::move(ys));
  for (double v = 1.0; v <= 4.0; v += 0.01) {
    EXPECT_NEAR(table.value(v), other(v), 1e-14);
    EXPECT_NEAR(table.slope(v), other.prime(v), 1e-12);
  }
}

/// The slope at an end is that of the parabola through three points, if it neither changes the sign
/// of the first chord nor is more than three times as steep.
TEST(Table, CubicEndsAsItsFirstChordsSay) {
  const auto first_slope = [](std::vector<double> x, std::vector<double> y) {
    const double at = x.front();
    return Table("f", std::move(x), std::move(y), Kind::monotone_cubic).slope(at);
  };
  EXPECT_NEAR(first_slope({0, 1, 3, 4}, {0, 1, 9, 10}), 0.0, 1e-14);              // parabola x^2
  EXPECT_NEAR(first_slope({1, 2, 4, 5}, {1, 4, 16, 17}), 2.0, 1e-13);             // again
  EXPECT_NEAR(first_slope({0, 1, 3, 4}, {0, 1, 13, 14}), 0.0, 1e-14);             // -2/3 there
  EXPECT_NEAR(first_slope({0, 1, 3, 4}, {0, 1, -15, -16}), 3.0, 1e-13);           // 4 there
  EXPECT_NEAR(first_slope({0, 1, 3, 4}, {0, 1, -5, -6}), 1.0 + 4.0 / 3.0, 1e-13); // as it is
}

TEST(Table, CubicOfMirroredPointsIsMirrored) {
  std::mt19937 engine(3);
  std::exponential_distribution<double> step(1.0);
  std::normal_distribution<double> height(0.0, 1.0);
  for (int round = 0; round < 50; ++round) {
    std::vector<double> x{0.0}, y{height(engine)};
    for (int i = 0; i < 5; ++i)
      x.push_back(x.back() + 0.1 + step(engine)), y.push_back(height(engine));
    std::vector<double> back_x, back_y(y.rbegin(), y.rend());
    for (auto at = x.rbegin(); at != x.rend(); ++at) back_x.push_back(x.back() - *at);
    const Table one("f", x, y, Kind::monotone_cubic),
        other("f", back_x, back_y, Kind::monotone_cubic);
    for (int k = 1; k < 100; ++k) {
      const double v = x.back() * k / 100.0;
      EXPECT_NEAR(one.value(v), other.value(x.back() - v), 1e-12);
    }
  }
}

TEST(Table, CubicKeepsMonotoneDataMonotone) {
  std::mt19937 engine(1);
  std::exponential_distribution<double> jump(1.0);
  for (int round = 0; round < 100; ++round) {
    std::vector<double> x{0.0}, y{0.0};
    for (int i = 0; i < 8; ++i) {
      x.push_back(x.back() + 0.01 + jump(engine));
      y.push_back(y.back() + std::pow(jump(engine), 4.0));
    }
    const Table table("f", x, y, Kind::monotone_cubic);
    double before = y.front();
    for (int k = 0; k <= 2000; ++k) {
      const double v = table.value(std::min(table.last(), table.last() * k / 2000.0));
      EXPECT_GE(v, before - 1e-13 * y.back());
      before = v;
    }
  }
}

TEST(Table, PassesThroughItsPointsAndEndsThere) {
  const std::vector<double> x{-1.0, 0.5, 2.0}, y{3.0, -1.0, 4.0};
  for (const Kind kind : {Kind::linear, Kind::monotone_cubic}) {
    const Table table("f", x, y, kind);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(table.value(x[i]), y[i]);
    for (const double outside : {-1.0000001, 2.0000001, std::nan(""), HUGE_VAL}) {
      EXPECT_TRUE(std::isnan(table.value(outside)));
      EXPECT_TRUE(std::isnan(table.slope(outside)));
    }
  }
}

TEST(Table, RefusesBadPoints) {
  EXPECT_THROW(Table("f", {0.0}, {1.0}, Kind::linear), std::invalid_argument);
  EXPECT_THROW(Table("f", {0.0, 1.0}, {1.0}, Kind::linear), std::invalid_argument);
  EXPECT_THROW(Table("f", {0.0, 0.0}, {1.0, 2.0}, Kind::linear), std::invalid_argument);
  EXPECT_THROW(Table("f", {0.0, NAN}, {1.0, 2.0}, Kind::linear), std::invalid_argument);
  EXPECT_THROW(Table("f", {0.0, 5e-324}, {0.0, 1.0}, Kind::linear), std::invalid_argument);
}

TEST(ParseTable, ReadsTheUsualForms) {
  for (const char* text : {"x,y\n0,1\n1, 3\n", "0;1\r\n1;3\r\n", "# soil\n 0 1 # start\n\n1\t3",
                           "\xef\xbb\xbfx y\n0 1\n+1 3e0"}) {
    const Table table = parse_table("f", text, Kind::linear);
    EXPECT_EQ(table.abscissae(), (std::vector<double>{0.0, 1.0})) << text;
    EXPECT_EQ(table.value(0.5), 2.0) << text;
  }
}

TEST(ParseTable, NamesTheLine) {
  using testing::HasSubstr;
  EXPECT_THAT(error_of("0 1\n1 2 3\n"), HasSubstr("line 2: two columns expected, found 3"));
  EXPECT_THAT(error_of("0 1\n1 two\n"), HasSubstr("line 2: \"two\" is not a number"));
  EXPECT_THAT(error_of("t;f\n0,5;1,5\n1;2\n"),
              HasSubstr("line 2: \"0,5\" is not a number: decimals follow a point"));
  EXPECT_THAT(error_of("t,f\n\"0\",\"1\"\n"), HasSubstr("numbers have no quotation marks"));
  EXPECT_THAT(error_of("0 1\n2 2\n1 2\n"), HasSubstr("line 3: the first column must increase"));
  EXPECT_THAT(error_of("0 1\nnan 2\n"), HasSubstr("line 2: a value is not finite"));
  EXPECT_THAT(error_of("a b\nc d\n0 1\n1 2\n"), HasSubstr("line 2: \"c\" is not a number"));
  EXPECT_THAT(error_of("0 1\n"), HasSubstr("needs at least two rows, found 1"));
  EXPECT_THAT(error_of(""), HasSubstr("found 0"));
  EXPECT_THAT(error_of(std::string("0 1\n\0 2\n", 8)), HasSubstr("line 2"));
}

TEST(ParseTable, SurvivesAnyBytes) {
  std::mt19937 engine(7);
  const std::vector<std::string> words{
      "0",  "1",   "2.5",         "3e1",  "-7", ",", ";",   " ",
      "\n", "\n",  "\n",          "\t",   "\r", "#", "x",   "nan",
      "+",  "1e9", "1e999999999", "\xef", ".",  "-", "inf", std::string(1, '\0')};
  int tables = 0;
  for (int i = 0; i < 100000; ++i) {
    std::string text;
    for (std::size_t k = engine() % 16; k > 0; --k) text += words[engine() % words.size()];
    try {
      const Table table = parse_table("f", text, Kind::monotone_cubic);
      EXPECT_TRUE(std::isfinite(table.value(table.first())));
      ++tables;
    } catch (const std::invalid_argument&) {
      continue; // the only error it may raise
    }
  }
  EXPECT_GT(tables, 0);
}
