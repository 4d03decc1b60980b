// Special functions against exact values.
#include "solver/kernel/scalar.hpp"

#include <gtest/gtest.h>

#include <numbers>

using namespace hvi::solver;

TEST(Special, Polygamma) { // analytic
  EXPECT_NEAR(polygamma(0, 1.0), -std::numbers::egamma, 1e-15);
  EXPECT_NEAR(polygamma(0, 0.5), -std::numbers::egamma - 2.0 * std::numbers::ln2, 1e-14);
  EXPECT_NEAR(polygamma(1, 1.0), std::pow(std::numbers::pi, 2) / 6.0, 1e-14);
  EXPECT_NEAR(polygamma(1, -0.5), std::pow(std::numbers::pi, 2) / 2.0 + 4.0, 1e-13);
  EXPECT_TRUE(std::isnan(polygamma(0, -2.0)));
  EXPECT_TRUE(std::isnan(polygamma(0.5, 2.0)));
}

TEST(Special, Bessel) { // analytic: J_{-n} = (-1)^n J_n, the recurrence, 1 = J_0^2 + 2 sum J_n^2
  for (const double x : {0.2, 1.0, 7.5, 40.0}) {
    EXPECT_NEAR(bessel_j(-1.0, x), -bessel_j(1.0, x), 1e-15);
    double sum = std::pow(bessel_j(0.0, x), 2);
    for (int n = 1; n < 80; ++n) {
      EXPECT_NEAR(bessel_j(n - 1, x) + bessel_j(n + 1, x), 2.0 * n / x * bessel_j(n, x), 1e-14);
      sum += 2.0 * std::pow(bessel_j(n, x), 2);
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
  }
  EXPECT_EQ(bessel_j(0.0, 0.0), 1.0);
  for (const double order : {0.5, 1e5, 1e18, -1e18, double(NAN)})
    EXPECT_TRUE(std::isnan(bessel_j(order, 1.0))) << order;
}

TEST(Special, WholePowersAreProducts) {
  for (const double x : {1.1, -0.3, 7.7}) {
    EXPECT_EQ(scalar_power(x, 2.0), x * x);
    EXPECT_EQ(scalar_power(x, 3.0), x * (x * x));
    EXPECT_EQ(scalar_power(x, -2.0), 1.0 / (x * x));
    EXPECT_NEAR(scalar_power(x, 13.0), std::pow(x, 13.0), 1e-14 * std::abs(std::pow(x, 13.0)));
  }
  EXPECT_EQ(scalar_power(0.0, 0.0), 1.0);
  EXPECT_TRUE(std::isnan(scalar_power(-1.0, 0.5)));
}
