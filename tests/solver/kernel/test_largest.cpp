// Largest values against dense sampling and closed forms: also where a function is defined on a
// part of the box only, jumps, or has infinite slopes.
#include "solver/kernel/largest.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

Expr x() { return Expr::variable(slot::x(0)); }
Expr y() { return Expr::variable(slot::x(1)); }

LargestValue largest_of(const Expr& f, std::vector<SearchBox> boxes, bool over_decades = false) {
  SearchSpace space;
  space.boxes = std::move(boxes);
  space.over_decades = over_decades;
  return LargestSearch(f, {slot::x(0), slot::x(1)})(space, {});
}
double at(const Expr& f, double a, double b) {
  return evaluate(f, [&](Slot s) { return s == slot::x(0) ? a : b; });
}

struct Known {
  Expr f;
  double low, high, value, place; ///< of x; y is in [0, 1]
  bool defined = true, jumps = false;
};

TEST(Largest, OfOneVariableInClosedForm) {
  const Expr one(1.0), half(0.5);
  const std::vector<Known> cases = {
      {x() * (one - x()), 0, 1, 0.25, 0.5},
      {sin(x()), 0, 10, 1.0, NAN},
      {one - sqrt(x() - half), 0, 1, 1.0, 0.5, false}, // defined on one half, largest at its edge
      {one + sqrt(half - x()), 0, 1, 1.0 + std::sqrt(0.5), 0.0, false},
      {one - sqrt(half - x()), 0, 1, 1.0, 0.5, false},
      {one + sqrt(x() - half), 0, 1, 1.0 + std::sqrt(0.5), 1.0, false},
      {sqrt(x()) - x(), 0, 1, 0.25, 0.25}, // an infinite slope at the end
      {one - abs(x() - Expr(0.3)), 0, 1, 1.0, 0.3},
      {select(less(x(), 0.3), x(), 0.1 - x()), 0, 1, 0.3, 0.3, true, true},
      {select(less(x(), 0.3), -x(), 2.0 - x()), 0, 1, 1.7, 0.3, true, true},
      {x() * exp(-x()), 0, 50, std::exp(-1.0), 1.0},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE(i);
    const Known& k = cases[i];
    const auto found = largest_of(k.f, {SearchBox{Bounds{k.low, k.high}, Bounds{0, 1}}});
    EXPECT_LE(found.value.low, k.value + 1e-15);
    EXPECT_GE(found.value.high, k.value - 1e-15);
    if (!k.defined) continue; // no value is proved
    const double close = k.jumps ? 1e-3 : 1e-6;
    EXPECT_NEAR(found.value.low, k.value, close);
    EXPECT_LE(found.value.high, k.value + close);
    if (!std::isnan(k.place)) {
      EXPECT_NEAR(found.at[0], k.place, 1e-3);
    }
  }
}

/// Random sums of waves, kinks, jumps and roots of two variables.
TEST(Largest, IsNeverBelowASampleNorFarAboveAll) {
  std::mt19937 random(11);
  const auto in = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  for (int scene = 0; scene < 25; ++scene) {
    SCOPED_TRACE(scene);
    Expr f(0.0);
    for (int k = 0; k < 3; ++k) {
      const Expr line = Expr(in(-2, 2)) * x() + Expr(in(-2, 2)) * y() + Expr(in(-0.5, 0.5));
      const Expr scale(in(-1, 1));
      switch (random() % 6) {
      case 0:
        f = f + scale * sin(3.0 * line);
        break;
      case 1:
        f = f + scale * abs(line);
        break;
      case 2:
        f = f + scale * select(less(line, 0.0), line, 0.7);
        break;
      case 3:
        f = f + scale * exp(line);
        break;
      case 4:
        f = f + scale * line * line;
        break;
      default:
        f = f + scale * sqrt(abs(line));
      }
    }
    const auto found = largest_of(
        f, {SearchBox{Bounds{-1, 0.2}, Bounds{-1, 1}}, SearchBox{Bounds{0.2, 1}, Bounds{-1, 1}}});
    double sampled = -INFINITY;
    for (int i = 0; i <= 100; ++i)
      for (int j = 0; j <= 100; ++j)
        sampled = std::max(sampled, at(f, -1 + i / 50.0, -1 + j / 50.0));
    EXPECT_GE(found.value.high, sampled - 1e-13);
    EXPECT_LE(found.value.low, sampled + 0.2); // what samples miss between them
    EXPECT_GE(found.value.low, sampled - 0.02);
    // Beside a jump the value at the place itself is not the one seen.
    const double there = at(f, found.at[0], found.at[1]);
    EXPECT_GE(there, found.value.low - 1e-9);
  }
}

/// Features of any size: cut at powers, a peak near the beginning of a long range is found, and on
/// a narrow one the middle does as well.
TEST(Largest, OverDecades) {
  for (const double place : {1e-9, 1e-4, 0.3, 7.0, 1e5, 2.1e8}) {
    const Expr s = x() / place;
    const auto found =
        largest_of(s * exp(1.0 - s), {SearchBox{Bounds{0, 1e9}, Bounds{0, 1}}}, true);
    EXPECT_NEAR(found.value.low, 1.0, 1e-6) << place;
    EXPECT_NEAR(found.value.high, 1.0, 1e-6) << place;
    EXPECT_NEAR(found.at[0] / place, 1.0, 1e-2);
  }
}

} // namespace
} // namespace hvi::solver
