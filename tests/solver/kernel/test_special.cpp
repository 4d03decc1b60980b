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

/// Analytic: E_{1/2}(-x), the recurrence, values at 0, the first terms at infinity, and (by mpmath,
/// 2^-n U((n + 1)/2, 1/2, x^2) / sqrt(pi) with 40 digits) numbers in between.
TEST(Special, ScaledErrorFunction) {
  const auto near = [](double got, double want, double relative = 2e-15) {
    EXPECT_NEAR(got, want, relative * std::abs(want));
  };
  near(erfcx(0, 0.5), 0.61569034419292587);
  near(erfcx(0, 3.9), 0.14031418160068974);
  near(erfcx(0, 4.1), 0.13383411641865199);
  near(erfcx(0, -5.0), 144009798674.66104);
  near(erfcx(1, 0.1), 0.47454388555084362);
  near(erfcx(1, 0.6), 0.22350675311580412);
  near(erfcx(1, 12.0), 0.0019389313690311355);
  near(erfcx(2, 2.0), 0.010450688150881637);
  near(erfcx(5, 0.15), 0.0057726095133005753);
  near(erfcx(5, 0.3), 0.0036172137176737152);
  near(erfcx(20, 1.5), 4.9288049569447987e-17);
  near(erfcx(100, 3.0), 5.687093637870716e-112);
  for (const double x :
       {-26.0, -3.0, -0.7, -1e-9, 0.0, 1e-7, 0.2, 0.49, 0.51, 1.0, 3.999, 4.0, 7.0})
    for (int n = 1; n < 60; ++n) {
      const double before = n == 1 ? 2.0 * std::numbers::inv_sqrtpi : erfcx(n - 2, x);
      const double size = before + 2.0 * std::abs(x) * erfcx(n - 1, x);
      EXPECT_NEAR(2.0 * n * erfcx(n, x), before - 2.0 * x * erfcx(n - 1, x), 1e-14 * size) << x;
    }
  for (const double x : {0.01, 0.3, 1.0, 3.0, 30.0, 1e3, 1e6})
    near(erfcx(0, x), mittag_leffler(0.5, 1.0, -x), 1e-13);
  for (const double x : {1e5, 1e100, 1e150}) {
    near(erfcx(0, x), std::numbers::inv_sqrtpi / x, 1e-10);
    near(x * erfcx(1, x), 0.5 * std::numbers::inv_sqrtpi / x, 1e-9);
  }
  EXPECT_EQ(erfcx(0, HUGE_VAL), 0.0);
  EXPECT_EQ(erfcx(0, -HUGE_VAL), HUGE_VAL);
  EXPECT_EQ(erfcx(3, -30.0), HUGE_VAL);
  for (const auto& [n, x] : {std::pair{0.5, 1.0}, {-1.0, 1.0}, {101.0, 1.0}, {0.0, double(NAN)}})
    EXPECT_TRUE(std::isnan(erfcx(n, x))) << n << " " << x;
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
