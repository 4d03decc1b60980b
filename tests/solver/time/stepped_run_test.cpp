// A run whose steps are taken one by one has the steps of a run, bit for bit.
#include "plans.hpp"
#include "solver/time/stepped_run.hpp"

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

} // namespace
} // namespace hvi::solver
