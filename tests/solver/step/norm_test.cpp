// The norm of V in a table, from the matrices of the tensors where they hold it, against the Gram
// matrix itself.
#include "solver/assembly/assembly.hpp"
#include "solver/step/step.hpp"
#include "tests/solver/time/plans.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// Runs, and compares the last norm. Does it come from the bases?
bool compare(const Plan& plan) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  const auto result = run(plan, d, RunSettings{});
  const double norm = std::sqrt(result.u.dot(gram_of_unknown(d.space, 0, false) * result.u));
  EXPECT_NEAR(result.final.at("strain"), norm, 1e-13 * norm);
  Timing timing;
  const Stepper stepper(plan, d, timing);
  const RunState& state = stepper.state();
  return !from_bases(state.balance, *state.formulation, d, strain_form(d.space)).empty();
}

TEST(Norm, OfTwoIsotropicTensorsNeedsNoMatrixOfItsOwn) {
  for (const int dim : {2, 3})
    for (const int order : {1, 2}) {
      Plan plan = slab(3, 16, dim, true);
      plan.problem.space.order = order;
      EXPECT_TRUE(compare(plan));
    }
}

TEST(Norm, IsTheSameWhereTheTensorsDoNotHoldIt) {
  EXPECT_FALSE(compare(slab(3, 4))); // too short for halves
  Plan plan = slab(3, 16);
  plan.problem.forms.resize(1); // one tensor
  plan.problem.histories.clear();
  EXPECT_FALSE(compare(plan));
  plan = slab(3, 16);
  plan.problem.forms[0].entries.front().coefficient = 20.0 + var(slot::x(0)); // varies
  EXPECT_FALSE(compare(plan));
  plan = slab(3, 16);
  plan.problem.space.dirichlet[0].value = {0.0, 0.01 * var(slot::t)}; // states hold imposed values
  EXPECT_FALSE(compare(plan));
  plan = slab(3, 16);
  plan.problem.forms[1].rule = Rule::nodal; // another quadrature
  plan.problem.forms[2].rule = Rule::nodal;
  EXPECT_FALSE(compare(plan));
}

} // namespace
} // namespace hvi::solver
