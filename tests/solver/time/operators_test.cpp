// The base matrices of several unknowns.
#include "solver/time/operators.hpp"
#include "solver/time/state.hpp"
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

} // namespace
} // namespace hvi::solver
