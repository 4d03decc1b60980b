// Least eigenvalues of tensors where they are least.
#include "solver/hypotheses/tensors.hpp"
#include "solver/plan/tensor_form.hpp"
#include "tests/solver/time/plans.hpp"

namespace hvi::solver {
namespace {

using namespace testing_plans;

Ellipticity of(const std::vector<FormTerm>& forms, const std::vector<TensorSpec>& tensors = {}) {
  Plan plan;
  plan.problem.mesh.cells = {4, 4, 1};
  plan.problem.parts = {all_cells("body"), all_cells("half")};
  plan.problem.parts[1].region.kind = RegionSpec::Kind::where;
  plan.problem.parts[1].region.children.resize(1);
  plan.problem.parts[1].region.predicate = less(var(slot::x(0)), 0.5);
  plan.problem.forms = forms;
  plan.problem.tensors = tensors;
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  return ellipticity(plan.problem, d, field_of_u(0));
}

FormTerm scaled(Expr by, int part = 0) {
  FormTerm form = elastic(2, part, field_of_u(0), {3.0, 1.0});
  for (auto& entry : form.entries) entry.coefficient = entry.coefficient * by;
  return form;
}

/// lambda tr I + 2 mu: 2 mu on matrices without trace.
TEST(Ellipticity, OfAConstantTensorIsExact) {
  const auto found = of({scaled(2.0)});
  EXPECT_FALSE(found.varies);
  EXPECT_NEAR(found.least, 4.0, 1e-14);
}

/// As the form of an isotropic tensor: by lambda and mu, against the eigenvalues of the entries.
TEST(Ellipticity, OfAWrittenTensorIsThatOfItsEntries) {
  const Expr x = var(slot::x(0)), y = var(slot::x(1));
  for (const auto& [lambda, mu] : {std::pair{3.0 - x, 1.0 + y}, {-1.2 + 0.3 * x, 1.0 + x * y}}) {
    Problem problem;
    problem.tensors = {{{}, {}, TensorSpec::Kind::isotropic, {lambda, mu}}};
    auto form = tensor_form(problem, 2, field_of_u(0), {0, 2.0 + x});
    const auto written = of({form}, problem.tensors);
    form.tensor.reset();
    const auto seen = of({form});
    EXPECT_NEAR(written.least, seen.least, 1e-13);
    EXPECT_EQ(written.at, seen.at);
    EXPECT_TRUE(written.varies);
  }
}

TEST(Ellipticity, IsLeastWhereTheTensorIsLeast) {
  const Expr x = var(slot::x(0)), y = var(slot::x(1));
  for (const auto& [by, at_right, at_top] : {std::tuple{2.0 - x - 0.5 * y, true, true},
                                             {1.0 + x + y, false, false},
                                             {1.0 + x - 0.5 * y, false, true},
                                             {2.0 - x + y, true, false}}) {
    const auto found = of({scaled(by)});
    EXPECT_TRUE(found.varies);
    EXPECT_EQ(found.at[0] > 0.5, at_right);
    EXPECT_EQ(found.at[1] > 0.5, at_top);
    const double here = evaluate(by, [&](Slot s) { return found.at[s == slot::x(1) ? 1 : 0]; });
    EXPECT_NEAR(found.least, 2.0 * here, 1e-13);
  }
}

/// Several forms add up, each where it acts; elsewhere a tensor is zero.
TEST(Ellipticity, OfSeveralFormsIsThatOfTheirSum) {
  const auto sum = of({scaled(2.0), scaled(-1.0, 1)}); // less on the left half
  EXPECT_TRUE(sum.varies);
  EXPECT_NEAR(sum.least, 2.0, 1e-14);
  EXPECT_LT(sum.at[0], 0.5);
  const auto more = of({scaled(2.0), scaled(1.0, 1)});
  EXPECT_NEAR(more.least, 4.0, 1e-14);
  EXPECT_GT(more.at[0], 0.5);
  EXPECT_NEAR(of({scaled(2.0), scaled(1.0)}).least, 6.0, 1e-14);
  EXPECT_EQ(of({scaled(2.0, 1)}).least, 0.0);
  EXPECT_GT(of({scaled(2.0, 1)}).at[0], 0.5);
}

} // namespace
} // namespace hvi::solver
