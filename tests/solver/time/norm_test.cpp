// The norm that a run prints is that of the solution it ends with, by the Gram matrix.
#include "solver/assembly/assembly.hpp"
#include "tests/solver/time/plans.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

void compare(const Plan& plan) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  const auto result = run(plan, d, RunSettings{});
  const double norm = std::sqrt(result.u.dot(gram_of_unknown(d.space, 0, false) * result.u));
  EXPECT_GT(norm, 0.0);
  EXPECT_NEAR(result.final.at("strain"), norm, 1e-13 * norm);
}

TEST(Norm, OfARunIsThatOfItsSolution) {
  for (const int dim : {2, 3})
    for (const int order : {1, 2}) {
      Plan plan = slab(3, 16, dim, true);
      plan.problem.space.order = order;
      compare(plan);
    }
}

TEST(Norm, OfARunCountsImposedValues) {
  Plan plan = slab(3, 16);
  plan.problem.space.dirichlet[0].value = {0.0, 0.01 * var(slot::t)};
  compare(plan);
}

} // namespace
} // namespace hvi::solver
