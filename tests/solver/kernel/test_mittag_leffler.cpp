// The Mittag-Leffler function against closed forms and against its power series in 90 digits.
#include "solver/kernel/scalar.hpp"

#include <boost/math/special_functions/erf.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using hvi::solver::mittag_leffler;

namespace {

using Wide = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<90>,
                                           boost::multiprecision::et_off>;

/// The series with 1 / Gamma(alpha k + beta) computed once for all x.
class Series {
public:
  Series(double alpha, double beta, int terms) {
    for (int k = 0; k < terms; ++k) {
      const Wide z = Wide(alpha) * k + beta;
      const bool pole = z <= 0 && z == floor(z);
      weights_.push_back(pole ? Wide(0) : Wide(1) / boost::math::tgamma(z));
    }
  }
  /// E(x) and x E'(x).
  std::pair<double, double> operator()(double x) const {
    Wide value = 0, slope = 0, power = 1;
    for (std::size_t k = 0; k < weights_.size(); ++k, power *= x) {
      value += power * weights_[k];
      slope += power * weights_[k] * static_cast<double>(k);
    }
    return {static_cast<double>(value), static_cast<double>(slope)};
  }

private:
  std::vector<Wide> weights_;
};

/// Radii |x|^(1/alpha) in the series, the integral and the asymptotic range, both signs.
void compare_with_series(double alpha, double beta) {
  const Series series(alpha, beta, static_cast<int>(220.0 / alpha));
  for (const double radius : {0.05, 0.4, 1.0, 2.5, 7.0, 19.0, 40.0, 44.9, 46.0})
    for (const double sign : {-1.0, 1.0}) {
      const double x = sign * std::pow(radius, alpha);
      const auto [value, x_slope] = series(x);
      // The second part is what a rounding of x alone does.
      const double allowed = 2e-14 * std::abs(value) + 6e-16 * std::abs(x_slope);
      EXPECT_NEAR(mittag_leffler(alpha, beta, x), value, allowed)
          << "alpha " << alpha << " beta " << beta << " x " << x;
    }
}

void expect_close(double got, double want, double relative) {
  EXPECT_NEAR(got, want, relative * std::abs(want));
}

} // namespace

TEST(MittagLeffler, IsItsSeriesForSmallOrders) {
  for (const double alpha : {0.3, 0.7})
    for (const double beta : {1.0, alpha, 2.5, -0.4}) compare_with_series(alpha, beta);
}

TEST(MittagLeffler, IsItsSeriesAroundOne) {
  for (const double alpha : {0.9, 0.999, 1.0, 1.01})
    for (const double beta : {1.0, alpha, 1.0 + alpha, 0.0}) compare_with_series(alpha, beta);
}

TEST(MittagLeffler, IsItsSeriesForLargeOrders) {
  for (const double alpha : {1.3, 1.7, 2.0})
    for (const double beta : {1.0, alpha, 6.0, 0.5}) compare_with_series(alpha, beta);
}

TEST(MittagLeffler, IsItsSeriesForLargeBeta) { // a pole close to 0 under a large power of s
  for (const double alpha : {0.13, 0.6, 1.6})
    for (const double beta : {12.0, 35.0}) compare_with_series(alpha, beta);
}

TEST(MittagLeffler, ObeysItsRecurrence) { // E_{a,b}(x) = 1/Gamma(b) + x E_{a,a+b}(x), analytic
  for (double alpha = 0.1; alpha < 2.0; alpha += 0.07)
    for (double beta = 0.3; beta < 4.0; beta += 0.31)
      for (double x = 0.03; x < 1e4; x *= 2.7) {
        const double left = mittag_leffler(alpha, beta, -x), first = 1.0 / std::tgamma(beta);
        const double right = first - x * mittag_leffler(alpha, alpha + beta, -x);
        EXPECT_NEAR(left, right, 1e-14 * (std::abs(left) + first + 1.0))
            << alpha << " " << beta << " " << x;
      }
}

TEST(MittagLeffler, AgreesWithClosedForms) { // analytic
  for (double x = 0.01; x < 60.0; x *= 1.3) {
    expect_close(mittag_leffler(1.0, 1.0, -x), std::exp(-x), 1e-15);
    expect_close(mittag_leffler(1.0, 2.0, x), std::expm1(x) / x, 2e-14);
    expect_close(mittag_leffler(1.0, 2.0, -x), std::expm1(-x) / -x, 2e-14);
    expect_close(mittag_leffler(1.0, 0.0, -x), -x * std::exp(-x), 1e-15);
    EXPECT_NEAR(mittag_leffler(2.0, 1.0, -x * x), std::cos(x), 1e-13);
    EXPECT_NEAR(mittag_leffler(2.0, 2.0, -x * x), std::sin(x) / x, 1e-13);
    expect_close(mittag_leffler(2.0, 1.0, x * x), std::cosh(x), 1e-13);
    const Wide scaled = exp(Wide(x) * x) * boost::math::erfc(Wide(x));
    if (x < 10.0) expect_close(mittag_leffler(0.5, 1.0, -x), static_cast<double>(scaled), 2e-14);
  }
}

TEST(MittagLeffler, KeepsItsShapeFarOut) {
  // E ~ -1 / (x Gamma(1 - alpha)) - 1 / (x^2 Gamma(1 - 2 alpha)), analytic
  const double x = -1e9, alpha = 0.6;
  const double want = -1.0 / (x * std::tgamma(0.4)) - 1.0 / (x * x * std::tgamma(-0.2));
  expect_close(mittag_leffler(alpha, 1.0, x), want, 1e-15);
  EXPECT_EQ(mittag_leffler(0.5, 1.0, 100.0), HUGE_VAL);
  EXPECT_EQ(mittag_leffler(1e-4, 3.0, 100.0), HUGE_VAL);
  EXPECT_EQ(mittag_leffler(0.7, 1.0, -HUGE_VAL), 0.0);
}

TEST(MittagLeffler, OutsideTheDomainIsNaN) {
  EXPECT_TRUE(std::isnan(mittag_leffler(0.0, 1.0, 1.0)));
  EXPECT_TRUE(std::isnan(mittag_leffler(2.1, 1.0, 1.0)));
  EXPECT_TRUE(std::isnan(mittag_leffler(NAN, 1.0, 1.0)));
  EXPECT_TRUE(std::isnan(mittag_leffler(0.5, 1.0, NAN)));
}
