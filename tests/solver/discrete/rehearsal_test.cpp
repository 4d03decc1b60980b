// What `plan` says of the cost of memories: counts of work, which do not depend on the machine.
#include "solver/discrete/rehearsal.hpp"
#include "tests/solver/time/plans.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// A bar that ages over decades: q(t, s) = g(xi(t) - xi(s)) xi'(s), xi(t) = 10 t - 9 log(1 + t).
Plan ageing(int steps, double grading, HistoryRoute route) {
  Plan plan;
  plan.problem.mesh.high = {1, 1, 0};
  plan.problem.mesh.cells = {1, 1, 1};
  plan.problem.parts = {all_cells("body"), group("left", "left"), group("right", "right")};
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {elastic(2, 0, field_of_u(0), {3, 2}),
                        elastic(2, 0, field_of_memory(0), {3, 2})};
  const Expr t = var(slot::t), s = t - var(slot::lag);
  const auto xi = [](const Expr& a) { return Expr(10.0) * a - Expr(9.0) * log(Expr(1.0) + a); };
  const Expr r = xi(t) - xi(s);
  plan.problem.histories = {
      {{}, {"q", {}, Expr(-0.3) * exp(-r) * (Expr(1.0) + Expr(9.0) * s / (Expr(1.0) + s))}}};
  plan.problem.loads = {force(2, {0.3, -0.2})};
  plan.problem.time.is_static = false;
  plan.problem.time.grid = uniform_grid(1.0, steps);
  for (double& time : plan.problem.time.grid) time = 1e6 * std::pow(time, grading);
  plan.options.route = route;
  plan.report.probes = {at_point("u", u_value(1), {1, 1, 0})};
  plan.report.tables = {{{}, {0}, 1, false, ""}};
  return plan;
}

TEST(Rehearsal, CountsTheFieldsThatTheRunReads) {
  for (const HistoryRoute route : {HistoryRoute::direct, HistoryRoute::tree})
    for (const double grading : {1.0, 8.0}) {
      const auto plan = ageing(240, grading, route);
      const auto found = rehearse_memory(plan, 0);
      EXPECT_EQ(found.rehearsed, 240);
      EXPECT_DOUBLE_EQ(found.all_reads, static_cast<double>(solve(plan).work.field_reads));
      EXPECT_GT(found.seconds, 0.0);
    }
}

// N (N - 1) / 2 fields are read by a direct sum: from the first third of the steps to all of them.
TEST(Rehearsal, GoesOnByThePowerOfTheSteps) {
  const auto plan = ageing(900, 8.0, HistoryRoute::direct);
  const int from = 10;
  const auto found = rehearse_memory(plan, from, 4e4);
  EXPECT_LT(found.rehearsed, 400);
  EXPECT_GE(found.rehearsed, 280);
  const double exact = 900.0 * 899.0 / 2, first = from * (from - 1.0) / 2;
  EXPECT_NEAR(found.all_reads, exact, 0.05 * exact);
  EXPECT_NEAR(found.reads, found.all_reads - 900.0 / from * first, 1.0);
}

TEST(Rehearsal, NothingWithoutMemory) {
  auto plan = ageing(20, 1.0, HistoryRoute::direct);
  plan.problem.histories.clear();
  plan.problem.forms.pop_back();
  EXPECT_EQ(rehearse_memory(plan, 4).rehearsed, 0);
}

} // namespace
} // namespace hvi::solver
