// Fits of errors and costs against laws they are made from, and the choice against brute force.
#include "solver/study/predict.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hvi::solver {
namespace {

Plan square(int n, int steps) {
  Plan plan;
  plan.problem.mesh.kind = MeshSpec::Kind::rectangle;
  plan.problem.mesh.high = {2, 1, 0};
  plan.problem.mesh.cells = {2 * n, n, 1};
  plan.problem.time.is_static = false;
  for (int i = 0; i <= steps; ++i) plan.problem.time.grid.push_back(static_cast<double>(i) / steps);
  return plan;
}

TEST(Predict, AnExactLawIsFoundByBothKindsOfDistance) {
  const double c = 0.3, p = 0.8;
  for (const Distance kind : {Distance::additive, Distance::orthogonal}) {
    std::vector<Rung> rungs;
    for (const double r : {1.0, 2.0, 4.0}) {
      const double a = c * std::pow(r, -p), b = c * std::pow(2 * r, -p);
      rungs.push_back({r, 2.0, kind == Distance::additive ? a - b : std::sqrt(a * a - b * b)});
    }
    const auto law = fit_error(rungs, 1.0, kind, 1e-12);
    EXPECT_NEAR(law.order, p, 1e-12);
    EXPECT_NEAR(law.at_one, c, 1e-12);
    EXPECT_NEAR(finer_error(rungs.back().distance, 2.0, p, kind), c * std::pow(8.0, -p), 1e-12);
  }
}

TEST(Predict, AnOrderAboveTheNominalOneIsNotBelieved) {
  const std::vector<Rung> rungs = {{1, 2, 1e-1}, {2, 2, 1e-3}};
  EXPECT_DOUBLE_EQ(fit_error(rungs, 1.0, Distance::additive, 1e-12).order, 1.0);
}

TEST(Predict, CostsGrowAsTheRunsSay) {
  const std::vector<CostPoint> points = {{1000, 0.01, 1e-3}, {4000, 0.05, 4.4e-3}};
  const auto law = fit_cost(points, 2);
  EXPECT_NEAR(law.seconds(4000, 10), 0.05 + 10 * 4.4e-3, 1e-12);
  EXPECT_GT(law.seconds(16000, 10), 4 * law.seconds(4000, 10));
  EXPECT_LT(law.seconds(16000, 10), 8 * law.seconds(4000, 10));
}

/// Brute force: no level and number of steps is cheaper and promises the same.
TEST(Predict, TheChoiceIsTheCheapestOfAll) {
  const SettingFamily family(square(16, 64));
  Candidate c;
  c.space = {0.4, 1.0, 3}, c.time = {0.6, 1.0, 3};
  c.unknowns_at_one = 80;
  const std::vector<CostPoint> points = {{1000, 0.01, 1e-3}, {4000, 0.05, 4.4e-3}};
  c.cost = fit_cost(points, 2);
  const std::vector<Candidate> all = {c};
  const double target = 0.02;
  const auto choice = cheapest(all, family, target, 1e6, 1e6);
  ASSERT_TRUE(choice);
  EXPECT_LE(choice->error, target);
  double least = 1e300;
  for (int level = 2; level < 400; level += 2)
    for (int steps = 8; steps < 2000; steps += 2)
      if (c.space.at(level) + c.time.at(steps) <= target)
        least = std::min(least, c.cost.seconds(80.0 * level * level, steps) +
                                    c.cost.seconds(20.0 * level * level, 1.5 * steps));
  EXPECT_NEAR(choice->seconds, least, 1e-9 * least);
  EXPECT_FALSE(cheapest(all, family, 1e-6, 1e4, 1e6));
}

TEST(Settings, MeshesAndGridsOfAFamilyAreNested) {
  const SettingFamily family(square(16, 64));
  EXPECT_EQ(family.plan().problem.mesh.cells[1], 4);
  const auto coarse = family.at({1, Scheme::backward_euler, 3, 10});
  const auto fine = family.at({2, Scheme::bdf2, 6, 20});
  EXPECT_EQ(coarse.problem.mesh.cells[0], 24);
  EXPECT_EQ(fine.problem.mesh.cells[0], 48);
  EXPECT_EQ(fine.problem.space.order, 2);
  for (std::size_t n = 0; n <= 10; ++n)
    EXPECT_EQ(coarse.problem.time.grid[n], fine.problem.time.grid[2 * n]);
}

TEST(Settings, APowerGradedGridStaysOne) {
  Plan plan = square(8, 16);
  for (double& t : plan.problem.time.grid) t = t * t;
  const auto grid = SettingFamily(plan).at({1, Scheme::backward_euler, 1, 10}).problem.time.grid;
  ASSERT_EQ(grid.size(), 11U);
  EXPECT_NEAR(grid[3], 0.09, 1e-12);
}

TEST(Settings, ListedTimesAreSubdivided) {
  Plan plan = square(8, 2);
  plan.problem.time.grid = {0, 0.1, 1};
  const auto grid = SettingFamily(plan).at({1, Scheme::backward_euler, 1, 4}).problem.time.grid;
  ASSERT_EQ(grid.size(), 5U);
  EXPECT_NEAR(grid[1], 0.05, 1e-15);
  EXPECT_NEAR(grid[3], 0.55, 1e-15);
}

TEST(Settings, AdaptedMeshesGrowByTheLevel) {
  const SettingFamily family(square(16, 64));
  const auto one = family.at({1, Scheme::backward_euler, 1, 8, adaptive}).problem.mesh;
  const auto three = family.at({1, Scheme::backward_euler, 3, 8, adaptive}).problem.mesh;
  EXPECT_EQ(one.cells, family.plan().problem.mesh.cells); // bisected from the coarsest
  EXPECT_EQ(one.adapted, 2 * 2 * one.cells[0] * one.cells[1]);
  EXPECT_EQ(three.adapted, 9 * one.adapted);
  EXPECT_EQ(three.cells, one.cells);
  Plan plan = square(16, 64);
  plan.problem.mesh.adapted = 4000; // the script's own wish: every setting
  EXPECT_EQ(SettingFamily(plan).at({1, Scheme::bdf2, 3, 8, 1.0}).problem.mesh.adapted,
            three.adapted);
}

} // namespace
} // namespace hvi::solver
