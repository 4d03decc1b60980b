// A run whose steps are taken one by one has the steps of a run, bit for bit.
#include "solver/time/stepped_run.hpp"
#include "tests/solver/time/plans.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

TEST(SteppedRun, HasTheStepsOfARun) {
  const Plan plan = slab(3, 8);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  std::vector<Vector> states;
  RunSettings settings;
  settings.on_step = [&](int, double, const Vector& u, const Vector&) { states.push_back(u); };
  const RunResult whole = run(plan, d, settings);
  SteppedRun stepped(plan, d);
  ASSERT_EQ(stepped.steps(), 8);
  for (int n = 1; n <= 8; ++n) {
    ASSERT_TRUE(stepped.advance());
    EXPECT_EQ(stepped.step(), n);
    EXPECT_EQ(stepped.u(), states[static_cast<std::size_t>(n) - 1]);
  }
  EXPECT_FALSE(stepped.advance());
  for (const auto& [name, value] : whole.final) EXPECT_EQ(stepped.value(name), value) << name;
  EXPECT_TRUE(std::isnan(stepped.value("no column")));
  const RunResult result = stepped.conclude();
  EXPECT_TRUE(result.certificate.certified);
  EXPECT_EQ(result.u, whole.u);
}

TEST(SteppedRun, MayEndEarly) {
  const Plan plan = slab(2, 8);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  SteppedRun stepped(plan, d);
  for (int n = 0; n < 3; ++n) ASSERT_TRUE(stepped.advance());
  const RunResult result = stepped.conclude();
  EXPECT_EQ(result.steps, 3);
  EXPECT_FALSE(result.certificate.certified);
}

/// The states of a run whose loads are three times as large after step `n`; 0: never.
std::vector<Vector> pulled_harder(const Plan& plan, int n) {
  Discretisation d;
  EXPECT_TRUE(discretise(plan, d).empty());
  Plan harder = plan;
  for (LoadTerm& load : harder.problem.loads)
    for (auto& entry : load.entries) entry.value = 3.0 * entry.value;
  SteppedRun stepped(plan, d);
  std::vector<Vector> out;
  while (stepped.advance()) {
    out.push_back(stepped.u());
    if (stepped.step() == n) stepped.change(harder);
  }
  EXPECT_TRUE(stepped.conclude().certificate.certified);
  return out;
}

TEST(SteppedRun, GoesOnAsAnotherPlan) {
  Plan plan = slab(3, 8);
  const auto states = pulled_harder(plan, 5), others = pulled_harder(plan, 0);
  const Expr factor = select(less(var(slot::t), Expr(0.65)), Expr(1.0), Expr(3.0));
  for (LoadTerm& load : plan.problem.loads)
    for (auto& entry : load.entries) entry.value = factor * entry.value;
  const auto expected = pulled_harder(plan, 0);
  for (std::size_t n = 0; n < states.size(); ++n)
    EXPECT_LT((states[n] - expected[n]).norm(), 1e-12 * expected[n].norm()) << n;
  EXPECT_GT((states[6] - others[6]).norm(), 0.1 * others[6].norm());
}

Plan with_loads_times(Plan plan, const Expr& factor) {
  for (LoadTerm& load : plan.problem.loads)
    for (auto& entry : load.entries) entry.value = factor * entry.value;
  return plan;
}

/// A change that fails leaves the one that it would have replaced: where the audit of a memory
/// finds a spike that its route has missed, and the run begins anew, its steps are those of a run
/// that was never asked for more.
TEST(SteppedRun, KeepsTheChangeThatARefusedOneWouldReplace) {
  constexpr int changed = 100, found = 330; // the spike is seen from step 301 on
  Plan plan = slab(1, 1000);
  const Expr lag = var(slot::lag), spike = (lag - 0.30025) / 1e-6;
  plan.problem.histories[0].kernel.expression = exp(-lag) + 1e3 * exp(-spike * spike);
  const auto harder = with_loads_times(plan, 3.0);
  const auto impossible = with_loads_times(plan, log(var(slot::x(0)) - 5.0));
  const auto states = [&](bool asks_for_more) {
    Discretisation d;
    EXPECT_TRUE(discretise(plan, d).empty());
    SteppedRun stepped(plan, d);
    std::vector<Vector> out;
    while (stepped.step() < found && stepped.advance()) {
      out.push_back(stepped.u());
      if (stepped.step() != changed) continue;
      stepped.change(harder);
      if (asks_for_more) {
        EXPECT_THROW(stepped.change(impossible), Failure);
      }
    }
    EXPECT_EQ(stepped.conclude().histories[0].route, "direct");
    return out;
  };
  const auto expected = states(false), asked = states(true);
  ASSERT_EQ(expected.size(), found);
  EXPECT_TRUE(asked == expected);
}

/// What lines and pictures show may be worked out with other numbers, across the plane, too.
TEST(SteppedRun, MayChangeWhatTheReportShows) {
  const auto showing = [](double modulus) {
    Plan plan = slab(2, 4);
    const Expr e = modulus * var(slot::field(field_of_u(0), slot::gradient(1, 1)));
    const FieldSpec stress{"stress", {}, {e, e, e, e}, {}, {0.3 * e, 0.0, 0.0}};
    plan.report.lines = {{{}, {stress}, {0.1, 0.5, 0}, {1.9, 0.5, 0}, 3, {}, "line"}};
    plan.report.pictures = {{{}, stress, {}, "picture"}};
    return plan;
  };
  const Plan plan = showing(1.0);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  SteppedRun stepped(plan, d);
  ASSERT_TRUE(stepped.advance());
  EXPECT_NO_THROW(stepped.change(showing(2.0)));
}

TEST(SteppedRun, RefusesAPlanThatIsNoLaterOne) {
  const Plan plan = slab(2, 4);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  SteppedRun stepped(plan, d);
  ASSERT_TRUE(stepped.advance());
  Plan other = plan;
  other.problem.histories[0].kernel.expression = exponential_kernel(0.7).expression;
  EXPECT_THROW(stepped.change(other), Failure);
  EXPECT_THROW(stepped.change(slab(2, 8)), Failure);
  EXPECT_THROW(stepped.change(slab(3, 4)), Failure);
  EXPECT_THROW(stepped.change(slab(2, 4, 2, true)), Failure);
  const auto why = [&](auto&& edit) {
    Plan edited = plan;
    edit(edited);
    try {
      stepped.change(edited);
    } catch (const Failure& failure) {
      return std::string(failure.what());
    }
    return std::string("nothing");
  };
  EXPECT_EQ(why([](Plan& p) {
              p.report.probes[0].point = {0.5, 0.5, 0};
            }),
            "the values change places or times of the report");
  EXPECT_EQ(why([](Plan& p) {
              FormTerm inertia;
              inertia.field = field_of_u(2);
              inertia.entries = {{slot::value(0), slot::value(0), 1.0}};
              p.problem.forms.push_back(inertia);
            }),
            "the values change what the run has begun with");
  EXPECT_EQ(why([](Plan& p) { p.problem.time.grid[4] = 1.5; }),
            "the values change the times of the steps");
  const Vector before = stepped.u();
  while (stepped.advance()) {
  }
  EXPECT_THROW(stepped.change(plan), Failure); // no step follows
  Discretisation alone;
  ASSERT_TRUE(discretise(plan, alone).empty());
  EXPECT_EQ(stepped.u(), run(plan, alone, {}).u);
  EXPECT_NE(stepped.u(), before);
}

} // namespace
} // namespace hvi::solver
