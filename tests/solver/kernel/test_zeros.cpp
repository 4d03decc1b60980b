// Zeros by interval isolation against zeros that are known.
#include "solver/kernel/zeros.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

const Expr t = Expr::variable(slot::t);

void expect_zeros(const Zeros& found, const std::vector<double>& known, double tolerance) {
  EXPECT_TRUE(found.complete);
  ASSERT_EQ(found.at.size(), known.size());
  for (std::size_t i = 0; i < known.size(); ++i) EXPECT_NEAR(found.at[i], known[i], tolerance);
}

TEST(Zeros, AllOfRandomWaves) {
  std::mt19937_64 random(1704);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int k = 0; k < 100; ++k) {
    const double w = std::exp(6.0 * unit(random)), phase = 6.0 * unit(random);
    std::vector<double> known;
    for (double n = std::ceil(phase / M_PI); (n * M_PI - phase) / w <= 1.0; ++n)
      known.push_back((n * M_PI - phase) / w);
    const Expr damped = sin(Expr(w) * t + Expr(phase)) * exp(Expr(-3.0) * t);
    expect_zeros(zeros(damped, slot::t, 0.0, 1.0), known, 1e-13);
  }
}

TEST(Zeros, SimpleAndDoubleOnesOfRandomProducts) {
  std::mt19937_64 random(1705);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int k = 0; k < 100; ++k) {
    std::vector<double> known;
    Expr f = exp(t);
    for (int r = 0; r < 4; ++r) {
      const double root = unit(random);
      const bool near = std::any_of(known.begin(), known.end(),
                                    [&](double x) { return std::abs(x - root) < 1e-3; });
      if (near) continue;
      known.push_back(root);
      f = f * pow(t - Expr(root), Expr(r == 0 ? 2.0 : 1.0));
    }
    std::sort(known.begin(), known.end());
    expect_zeros(zeros(f, slot::t, -1.0, 1.0), known, 1e-9);
  }
}

TEST(Zeros, TopsOfATriangleWave) {
  // 1 - sin^2 touches zero where the arcsine of the sine has its corners.
  const Expr s = sin(Expr(10.0) * t);
  const Zeros found = zeros(Expr(1.0) - s * s, slot::t, 0.0, 1.0);
  expect_zeros(found, {0.05 * M_PI, 0.15 * M_PI, 0.25 * M_PI}, 1e-13);
}

TEST(Zeros, NoneWhereAFunctionOnlyComesCloseOrVanishesOnAStretch) {
  expect_zeros(zeros(pow(t - Expr(0.3), Expr(2.0)) + Expr(1e-9), slot::t, 0.0, 1.0), {}, 0.0);
  expect_zeros(zeros(max(t - Expr(2.0), Expr(0.0)), slot::t, 0.0, 1.0), {}, 0.0);
}

TEST(Zeros, ANarrowDipIsFound) {
  const Expr dip = exp(-pow((t - Expr(0.271)) / Expr(1e-5), Expr(2.0)));
  const Zeros found = zeros(Expr(0.5) - dip, slot::t, 0.0, 1.0);
  const double half = 1e-5 * std::sqrt(std::log(2.0));
  expect_zeros(found, {0.271 - half, 0.271 + half}, 1e-15);
}

} // namespace
} // namespace hvi::solver
