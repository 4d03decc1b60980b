// The evolution on the contact unknowns against the one on all unknowns: the same plans, run both
// ways. Random ones vary tensors, kernels, laws, loads, initial states, schemes and grids.
#include "tests/solver/time/plans.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// The slab with one tensor for everything, and a table without interior fields.
Plan one_tensor(int n, int steps, int dim = 2, bool friction = false) {
  Plan plan = slab(n, steps, dim, friction);
  const auto b = from_young(70, 0.3);
  plan.problem.forms[0] = elastic(dim, body, field_of_u(1), b, 0.2);
  plan.report.probes = {at_point("u_y", u_value(1), {1, 0, dim == 3 ? 0.5 : 0.0}),
                        at_point("u_x", u_value(0), {1.5, 0.5, dim == 3 ? 0.5 : 0.0}),
                        integral("reaction", var(slot::multiplier(0, 0)), ground)};
  plan.report.tables = {{{}, {0, 1, 2}, 1, false, ""}};
  return plan;
}

void expect_same(Plan plan, double tolerance, const std::string& what) {
  const auto reduced = solve(plan);
  EXPECT_EQ(reduced.path, "") << what;
  plan.options.proportional_path = false;
  const auto full = solve(plan);
  EXPECT_NE(full.path, "") << what;
  EXPECT_EQ(reduced.unknowns, full.unknowns) << what;
  EXPECT_TRUE(reduced.certificate.certified && full.certificate.certified) << what;
  const double scale = full.u.lpNorm<Eigen::Infinity>();
  EXPECT_GT(scale, 0.0) << what;
  EXPECT_LE((reduced.u - full.u).lpNorm<Eigen::Infinity>(), tolerance * scale) << what;
  for (const auto& [name, column] : full.columns) {
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < column.size(); ++i) {
      largest = std::max(largest, std::abs(column[i]));
      difference = std::max(difference, std::abs(column[i] - reduced.columns.at(name)[i]));
    }
    EXPECT_LE(difference, tolerance * largest) << what << ", " << name;
  }
}

TEST(Proportional, SlabEqualsTheGeneralPath) { expect_same(one_tensor(8, 40), 1e-10, "slab"); }
TEST(Proportional, SlabWithFrictionEqualsTheGeneralPath) {
  expect_same(one_tensor(8, 40, 2, true), 1e-10, "slab with friction");
}
TEST(Proportional, Slab3DEqualsTheGeneralPath) {
  expect_same(one_tensor(3, 20, 3, true), 1e-10, "3D");
}

/// Sizes between one half and one and a half.
double about_one(std::mt19937& random) {
  return 0.5 + std::uniform_real_distribution<double>()(random);
}

Plan random_plan(std::mt19937& random) {
  const auto coin = [&] { return random() % 2 == 0; };
  Plan plan = one_tensor(4 + static_cast<int>(random() % 4), 24, 2, coin());
  const Expr t = var(slot::t);
  const auto b = from_young(70 * about_one(random), 0.2 + 0.2 * about_one(random));
  plan.problem.forms = {elastic(2, body, field_of_u(1), b, 0.3 * about_one(random)),
                        elastic(2, body, field_of_u(0), b)};
  plan.problem.histories.clear();
  if (coin()) {
    plan.problem.forms.push_back(elastic(2, body, field_of_memory(0), b, -0.5 * about_one(random)));
    plan.problem.histories = {{{}, exponential_kernel(about_one(random)), {}}};
  }
  if (coin())
    plan.problem.forms.push_back(elastic(2, body, field_of_u(0), b, 0.5 * about_one(random)));
  plan.problem.loads = {force(body, {0.0, -10.0 * about_one(random) * t}),
                        force(flank, {3.0 * about_one(random) * t * t})};
  if (coin()) plan.problem.loads.push_back(force(body, {sin(3.0 * t), 0.0}));
  if (coin()) plan.problem.time.scheme = Scheme::bdf2;
  if (coin()) plan.problem.time.sampling = LoadSampling::average;
  if (coin()) { // steps of two lengths
    for (std::size_t n = 13; n < plan.problem.time.grid.size(); ++n)
      plan.problem.time.grid[n] = plan.problem.time.grid[n - 1] + 0.5 / 24;
  }
  if (coin()) // zero on the roof
    plan.problem.time.initial = {0.0, 0.01 * var(slot::x(0)) * (Expr(1.0) - var(slot::x(1)))};
  return plan;
}

TEST(Proportional, RandomPlansEqualTheGeneralPath) {
  std::mt19937 random(5);
  for (int k = 0; k < 24; ++k) expect_same(random_plan(random), 1e-9, "plan " + std::to_string(k));
}

// The steps' matrix is a multiple of the factor's: estimates that forget the multiple are off by
// it.
TEST(Proportional, ErrorsAreEstimatedAsOnTheGeneralPath) {
  for (const int steps : {4, 40, 4000}) {
    Plan plan = one_tensor(6, 4);
    plan.problem.time.grid = uniform_grid(4.0 / steps, 4);
    const auto reduced = solve(plan).forward_error;
    plan.options.proportional_path = false;
    const auto full = solve(plan).forward_error;
    const auto agree = [&](double a, double b, const std::string& what) {
      EXPECT_GT(a, 0.0) << what;
      EXPECT_LT(std::abs(std::log10(a / b)), 1.0)
          << what << ", " << steps << ": " << a << " / " << b;
    };
    agree(reduced.solution, full.solution, "solution");
    ASSERT_EQ(reduced.columns.size(), full.columns.size());
    for (std::size_t i = 0; i < full.columns.size(); ++i)
      agree(reduced.columns[i].absolute, full.columns[i].absolute, full.columns[i].name);
  }
}

/// What a run comes to: its certificate, or the sentence it ends with and the steps before.
struct End {
  std::string said;
  int steps = 0;
  double equilibrium = 0;
};
End end_of(const Plan& plan, bool seen) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  RunSettings settings;
  if (seen) settings.on_step = [](int, double, const Vector&, const Vector&) {};
  RunResult partial;
  try {
    const auto result = run(plan, d, settings, &partial);
    EXPECT_TRUE(result.certificate.certified);
    return {"", result.steps, result.certificate.equilibrium};
  } catch (const Failure& failure) {
    return {failure.what(), partial.steps, 0};
  }
}

// A run of which every step is seen makes its checks on all rows in their steps, another one
// together at the end. Tolerances above rounding pass all of them, those below fail the first; in
// between it is rounding that decides, which differs from solve to solve.
TEST(Proportional, ChecksMadeTogetherDecideAsThoseInTheirSteps) {
  int certified = 0, refused = 0;
  for (const int steps : {20, 45})
    for (double tolerance = 1e-10; tolerance > 1e-19; tolerance /= 2) {
      if (tolerance > 1e-17 && tolerance < 2e-15) continue;
      Plan plan = one_tensor(6, steps);
      plan.options.tolerance = tolerance;
      const auto together = end_of(plan, false), each = end_of(plan, true);
      if (together.said.empty() != each.said.empty()) {
        ADD_FAILURE() << tolerance << ": " << together.said << " / " << each.said;
        continue;
      }
      (each.said.empty() ? certified : refused) += 1;
      const auto where = [](const End& end) { return end.said.substr(0, end.said.find(':')); };
      EXPECT_EQ(where(together), where(each)) << tolerance;
      EXPECT_EQ(together.steps, each.steps) << tolerance;
      EXPECT_LE(std::abs(together.equilibrium - each.equilibrium), 1e-14) << tolerance;
    }
  EXPECT_GT(certified, 10);
  EXPECT_GT(refused, 4);
}

// Below what rounding leaves on all rows and above what it leaves on the contact rows every step
// has its certificate until the checks are made: then the run begins again, and says which step
// failed.
TEST(Proportional, ACheckThatFailsLateMakesTheRunBeginAgain) {
  int begun_again = 0;
  for (double tolerance = 1e-15; tolerance > 1e-17; tolerance /= 1.1) {
    Plan plan = one_tensor(6, 20);
    plan.options.tolerance = tolerance;
    Discretisation d;
    for (const auto& mistake : discretise(plan, d)) throw mistake;
    RunSettings settings;
    int starts = 0;
    settings.progress = [&](const Progress& p) { starts += p.step == 1; };
    RunResult partial;
    try {
      // the step that failed may pass the second time: its check is rounded in another way
      EXPECT_LE(run(plan, d, settings, &partial).certificate.equilibrium, tolerance);
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.kind, FailureKind::not_certified);
      // What is kept stands before the step that is named.
      const std::string named = fmt::format("step {} ", partial.steps + 1);
      EXPECT_NE(std::string(failure.what()).find(named), std::string::npos) << failure.what();
    }
    // On the contact unknowns, the same with each check in its step, on all unknowns.
    EXPECT_LE(starts, 3) << tolerance;
    begun_again += starts > 1 ? 1 : 0;
  }
  EXPECT_GT(begun_again, 0);
}

TEST(Proportional, TheConditionThatFailsIsNamed) {
  const auto why = [](Plan plan) { return solve(plan).path; };
  EXPECT_EQ(why(one_tensor(3, 4)), "");
  EXPECT_NE(why(slab(3, 4)).find("not multiples of one tensor"), std::string::npos);
  Plan plan = one_tensor(3, 4);
  plan.report.probes.push_back(norm("strain"));
  plan.report.tables[0].probes.push_back(3);
  EXPECT_NE(why(plan).find("`strain`"), std::string::npos);
  plan = one_tensor(3, 4);
  plan.problem.loads.push_back(force(body, {sin(var(slot::t) * var(slot::x(0))), 0.0}));
  EXPECT_NE(why(plan).find("does not separate"), std::string::npos);
  plan = one_tensor(3, 4);
  plan.problem.space.dirichlet[0].value = {0.0, 0.01 * var(slot::t)};
  EXPECT_NE(why(plan).find("boundary values"), std::string::npos);
  plan = one_tensor(3, 4);
  plan.problem.law_terms.clear();
  plan.report.probes.pop_back();
  plan.report.tables[0].probes.pop_back();
  EXPECT_NE(why(plan).find("no contact law"), std::string::npos);
}

TEST(Proportional, AContactThatNeverTouchesCostsNoNewtonIteration) {
  Plan plan = one_tensor(4, 16);
  plan.problem.loads = {force(body, {0.0, 10.0 * var(slot::t)})}; // away from the ground
  for (const bool reduced : {true, false}) {
    plan.options.proportional_path = reduced;
    EXPECT_EQ(solve(plan).work.newton, 0);
  }
}

} // namespace
} // namespace hvi::solver
