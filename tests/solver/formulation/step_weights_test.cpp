// The step whose matrix is the worst, found by boxes, against all of them.
#include "solver/formulation/step_weights.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace hvi::solver {
namespace {

using Eigen::VectorXd;

/// A maximum of linear functions, the largest value of which over the steps is `worst`.
struct Ratio {
  std::vector<VectorXd> planes;
  double scale = 1.0;
  double operator()(const VectorXd& c) const {
    double out = 0.0;
    for (const VectorXd& plane : planes) out = std::max(out, plane.dot(c));
    return scale * out;
  }
};

TEST(WorstStep, IsThatOfAllSteps) {
  std::mt19937_64 random(812);
  std::uniform_real_distribution<double> size(0.5, 2.0), side(-1.0, 1.0);
  for (const double worst : {0.3, 0.9, 1.7, 40.0})
    for (int trial = 0; trial < 8; ++trial) {
      StepWeights weights;
      for (int n = 1; n <= 300; ++n) {
        weights.steps.push_back(n);
        weights.c.push_back(VectorXd::NullaryExpr(3, [&] { return size(random); }));
      }
      Ratio ratio;
      for (int i = 0; i < 3; ++i)
        ratio.planes.push_back(VectorXd::NullaryExpr(3, [&] { return side(random); }));
      ratio.planes.push_back(VectorXd::Constant(3, 0.1));
      double largest = 0.0;
      for (const VectorXd& c : weights.c) largest = std::max(largest, ratio(c));
      ratio.scale = worst / largest;
      const WorstStep found = worst_step(weights, ratio, 100000);
      SCOPED_TRACE(worst);
      EXPECT_TRUE(found.within_budget);
      EXPECT_EQ(found.ratio, ratio(weights.c[static_cast<std::size_t>(found.step - 1)]));
      EXPECT_GE(found.ratio, worst / (1.0 + 1.001e-3));
      EXPECT_LE(found.ratio, worst * (1.0 + 1e-14));
      EXPECT_GE(found.bound, worst * (1.0 - 1e-14));
      EXPECT_LE(found.bound, worst * (1.0 + 1.001e-3));
    }
}

} // namespace
} // namespace hvi::solver
