// The base matrices of several unknowns.
#include "solver/discrete/operators.hpp"
#include "solver/discrete/state.hpp"
#include "solver/plan/tensor_form.hpp"
#include "tests/solver/time/plans.hpp"

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// The slab with a temperature, and this form besides.
Plan warm_slab(std::vector<FormTerm> further) {
  auto plan = slab(3, 2);
  plan.problem.space.more = {{"theta", "W", {}, false, 1}};
  FormTerm conducts = diffusion(2, body, field_of_u(0));
  for (auto& entry : conducts.entries)
    entry.test = slot::of_unknown(1, entry.test), entry.trial = slot::of_unknown(1, entry.trial);
  plan.problem.forms = {elastic(2, body, field_of_u(0), {1, 1}), conducts};
  for (auto& form : further) plan.problem.forms.push_back(form);
  plan.problem.histories.clear();
  plan.problem.law_terms.clear();
  plan.problem.time.initial.clear();
  plan.report = {};
  return plan;
}

/// Entries of all base matrices between equations of u and of theta, stored zeros among them.
int entries_between(const Plan& plan) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  const StateLayout layout = make_layout(d.space, d.dofs);
  const Operators operators = assemble_operators(plan.problem, d, layout, 1);
  const auto unknown_of = [&](Eigen::Index i) {
    return d.space.block_of(layout.dof_of[static_cast<std::size_t>(i)] % d.space.components);
  };
  int out = 0;
  for (const SparseMatrix& base : operators.bases)
    for (int i = 0; i < base.rows(); ++i)
      for (SparseMatrix::InnerIterator it(base, i); it; ++it)
        out += unknown_of(i) != unknown_of(it.col());
  return out;
}

TEST(Operators, UnknownsThatNoFormCouplesHaveNoEntriesInCommon) {
  EXPECT_EQ(entries_between(warm_slab({})), 0);
  FormTerm expands; // theta d v_x / dx
  expands.part = body;
  expands.field = field_of_u(0);
  expands.entries.push_back({slot::gradient(0, 0), slot::of_unknown(1, slot::value(0)), Expr(1.0)});
  EXPECT_GT(entries_between(warm_slab({expands})), 0);
}

Operators operators_of(const Plan& plan) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  return assemble_operators(plan.problem, d, make_layout(d.space, d.dofs), 1);
}

/// An orthotropic body, its axes turned in the plane: its entries are symmetric to rounding only.
Plan turned_slab(const Expr& factor) {
  auto plan = slab(3, 2);
  const double c = std::cos(0.4), s = std::sin(0.4);
  plan.problem.tensors = {{{},
                           {},
                           TensorSpec::Kind::orthotropic,
                           {30.0, 7.0, 5.0, 0.21, 0.13, 0.17, 2.9, 3.1, 1.7},
                           {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}}}};
  plan.problem.forms = {tensor_form(plan.problem, 2, field_of_u(1), {0, 0.3 * factor}),
                        tensor_form(plan.problem, 2, field_of_u(0), {0, factor})};
  for (FormTerm& form : plan.problem.forms) form.part = body;
  plan.problem.histories.clear();
  plan.report = {};
  return plan;
}

// However many forms: what stands beside u alone is one matrix, their sum.
TEST(Operators, FormsOfOneFieldShareAMatrix) {
  FormTerm springs, slides;
  springs.part = slides.part = body;
  springs.field = slides.field = field_of_u(0);
  springs.entries.push_back({slot::value(0), slot::value(0), Expr(2.0)});
  slides.entries.push_back({slot::value(1), slot::gradient(0, 0), Expr(3.0)});
  const Operators operators = operators_of(warm_slab({springs, slides}));
  ASSERT_EQ(operators.n_bases(), 1);
  SparseMatrix sum;
  for (const FormTerm& form : warm_slab({springs, slides}).problem.forms) {
    auto plan = warm_slab({});
    plan.problem.forms = {form};
    const Operators one = operators_of(plan);
    sum = sum.size() == 0 ? SparseMatrix(one.weights(field_of_u(0), 0) * one.bases[0])
                          : SparseMatrix(sum + one.weights(field_of_u(0), 0) * one.bases[0]);
  }
  EXPECT_LT((operators.weights(field_of_u(0), 0) * operators.bases[0] - sum).norm(),
            1e-14 * sum.norm());
}

// With factors that no entry shows: x is no product of the two, and sums do not cancel.
TEST(Operators, FormsOfOneTensorAreMultiplesAsWritten) {
  const Expr place = 1.0 + var(slot::x(0));
  auto plan = turned_slab(place);
  const Operators written = operators_of(plan);
  ASSERT_EQ(written.n_bases(), 1);
  EXPECT_TRUE(written.symmetric);
  EXPECT_EQ(written.weights(field_of_u(0), 0) / written.weights(field_of_u(1), 0), 1.0 / 0.3);
}

// The stiffness of a damaged body in turned axes: that its matrix stays symmetric follows from how
// it was written.
TEST(Operators, MaterialsThatStatesChangeStaySymmetric) {
  auto plan = turned_slab(1.0 - var(slot::state(0)));
  StateTerm damage;
  damage.name = "d";
  damage.part = body;
  damage.rate = 0.1;
  damage.initial = 0.0;
  plan.problem.states = {damage};
  const Operators written = operators_of(plan);
  EXPECT_TRUE(written.symmetric);
  EXPECT_FALSE(written.mirrored); // nor are the entries the same to the last bit
  EXPECT_EQ(written.changing.size(), 1u);
  for (FormTerm& form : plan.problem.forms) form.tensor.reset();
  EXPECT_FALSE(operators_of(plan).symmetric);
}

} // namespace
} // namespace hvi::solver
