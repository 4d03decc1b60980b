// How much steps together make of the rounding of one, and what that does to rates.
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

const ColumnError& column(const RunResult& run, const std::string& name) {
  const auto& all = run.forward_error.columns;
  return *std::ranges::find(all, name, &ColumnError::name);
}

/// A viscous slab without ground under a load that rises.
Plan viscous(int steps) {
  Plan plan = slab(3, steps);
  plan.problem.laws.clear(), plan.problem.law_terms.clear();
  plan.report.probes = {at_point("u", u_value(1), {1, 0, 0}),
                        at_point("v", var(slot::field(field_of_u(1), slot::value(1))), {1, 0, 0})};
  plan.report.tables = {{{}, {0, 1}, 1, false, ""}};
  return plan;
}

/// However many steps there are: errors of displacements add up over them, and those of rates are
/// theirs by the whole time, not by a step.
TEST(RoundingEstimate, ErrorsOfRatesAreThoseOfTheWholeTime) {
  const auto by_time = [](int steps) {
    const RunResult run = solve(viscous(steps));
    EXPECT_GT(run.forward_error.amplification, 0.5 * steps);
    return column(run, "v").absolute / column(run, "u").absolute;
  };
  const double few = by_time(16), many = by_time(256);
  EXPECT_LT(many, 3.0 * few);
  EXPECT_GT(many, few / 3.0);
}

/// Where a law acts on the rate nothing is known but that each step may add one error; where mass
/// carries velocities on, each adds to those of all later steps.
TEST(RoundingEstimate, LawsOnRatesAddUpStepByStep) {
  constexpr int steps = 6;
  Plan plan = slab(2, steps, 2, true);
  plan.problem.law_terms.back().field = field_of_u(1);
  EXPECT_EQ(solve(plan).forward_error.amplification, steps);
  FormTerm inertia;
  inertia.field = field_of_u(2);
  inertia.entries = {{slot::value(0), slot::value(0), 3.0}, {slot::value(1), slot::value(1), 3.0}};
  plan.problem.forms.push_back(inertia);
  EXPECT_EQ(solve(plan).forward_error.amplification, steps * steps);
}

/// What a step leaves of its equation is no random force: its answer is the state's error itself,
/// and the columns have three times that, which is the margin of all estimates.
TEST(RoundingEstimate, WhatAStepLeavesIsAnswered) {
  Plan plan = viscous(1);
  plan.problem.time = {};
  plan.problem.histories.clear();
  plan.problem.forms = {elastic(2, body, field_of_u(0), from_young(70, 0.3))};
  plan.problem.loads = {force(body, {0.0, -10.0})};
  plan.report.probes.pop_back();
  plan.report.tables.front().probes = {0};
  const double exact = solve(plan).final.at("u");
  plan.options.solver = LinearSolver::iterative; // ends at the tolerance, and not at rounding
  const RunResult rough = solve(plan);
  const double off = std::abs(rough.final.at("u") - exact);
  EXPECT_GT(off, 1e-13 * std::abs(exact));
  EXPECT_NEAR(column(rough, "u").absolute / off, 3.0, 0.1);
}

} // namespace
} // namespace hvi::solver
