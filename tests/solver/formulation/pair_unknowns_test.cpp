// Jumps across pairs as unknowns: what the reduced problem has then, and the same answers.
#include "solver/formulation/formulation.hpp"
#include "solver/formulation/pair_unknowns.hpp"
#include "tests/solver/time/plans.hpp"

namespace hvi::solver {
namespace {

using namespace testing_plans;

struct Made {
  Plan plan;
  Discretisation discretisation;
  std::unique_ptr<Formulation> formulation;
  explicit Made(Plan of) : plan(std::move(of)) {
    for (const auto& mistake : discretise(plan, discretisation)) throw mistake;
    formulation = formulate(plan, discretisation);
  }
  const Contact& contact() const { return formulation->contact(); }
};

/// Rows of one entry each, and as many rows at an unknown.
void expect_own_unknowns(const Contact& contact) {
  const SparseMatrix& g = contact.problem.g;
  std::vector<int> users(static_cast<std::size_t>(g.cols()), 0);
  for (int row = 0; row < g.rows(); ++row) {
    EXPECT_EQ(g.row(row).nonZeros(), 1) << row;
    for (SparseMatrix::InnerIterator it(g, row); it; ++it) {
      EXPECT_NEAR(it.value(), 1.0, 1e-14);
      ++users[static_cast<std::size_t>(it.col())];
    }
  }
  for (const int rows : users) EXPECT_EQ(rows, 1);
}

TEST(PairUnknowns, AreOnesOfEachPoint) {
  for (const int dim : {2, 3}) {
    const Made made(two_blocks(3, 4, dim));
    const int nodes = dim == 2 ? 7 : 7 * 4; // of the first side
    ASSERT_NE(made.contact().change, nullptr);
    EXPECT_EQ(static_cast<int>(made.contact().unknowns.size()), dim * nodes);
    EXPECT_GT(made.contact().loaded.size(), made.contact().unknowns.size());
    expect_own_unknowns(made.contact());
  }
}

/// Of a law on the normal alone the other displacements stay as they are.
TEST(PairUnknowns, AreThoseThatLawsSee) {
  Plan plan = two_blocks(3, 4, 3);
  plan.problem.law_terms.pop_back();
  const Made made(plan);
  EXPECT_EQ(made.contact().unknowns.size(), 28u);
  expect_own_unknowns(made.contact());
}

/// c is what the laws see of any increment: G d = G_c c.
TEST(PairUnknowns, AreTheJumps) {
  const Made made(two_blocks(2, 4, 3));
  const auto n = made.formulation->layout().n_unknowns;
  const Vector d = Vector::LinSpaced(n, 0.0, 3.0 * n).array().sin();
  Vector c;
  contact_part(made.contact(), d, c);
  const Vector seen = made.contact().g * d, of_c = made.contact().problem.g * c;
  EXPECT_LT((seen - of_c).cwiseAbs().maxCoeff(), 1e-13);
}

/// Where imposed values take a part of what a law sees, the second side's nodes stay.
TEST(PairUnknowns, GoWithImposedValues) {
  Plan plan = two_blocks(3, 4, 2);
  plan.problem.parts.push_back(group("upper end", "upper.left"));
  plan.problem.space.dirichlet.push_back(clamp(5, 0));
  const Made made(plan);
  ASSERT_NE(made.contact().change, nullptr);
  Vector c;
  const auto& layout = made.formulation->layout();
  const Vector d = Vector::LinSpaced(layout.n_unknowns, 0.0, layout.n_unknowns).array().cos();
  contact_part(made.contact(), d, c);
  Vector state = Vector::Zero(layout.n_state);
  state.head(d.size()) = d;
  EXPECT_LT((made.contact().g * state - made.contact().problem.g * c).cwiseAbs().maxCoeff(), 1e-13);
}

/// Joined where they touch, two loose pieces would be loose together.
TEST(PairUnknowns, AreNotTakenWhereBothPiecesAreLoose) {
  Plan one = two_blocks(3, 4, 2), both = one;
  one.problem.space.dirichlet = {clamp(4)};
  both.problem.space.dirichlet = {clamp(4, 1)};
  EXPECT_NE(Made(one).contact().change, nullptr);
  EXPECT_EQ(Made(both).contact().change, nullptr);
}

TEST(PairUnknowns, GiveTheSameAnswers) {
  for (const int dim : {2, 3})
    for (const bool rate : {false, true}) {
      Plan jumps = two_blocks(dim == 2 ? 4 : 2, 6, dim);
      if (rate) jumps.problem.law_terms.back().field = field_of_u(1);
      Plan both = jumps;
      both.options.jumps_as_unknowns = false;
      const auto a = solve(jumps), b = solve(both);
      EXPECT_LT(a.contact_unknowns, b.contact_unknowns);
      EXPECT_LT((a.u - b.u).lpNorm<Eigen::Infinity>(), 1e-10 * b.u.lpNorm<Eigen::Infinity>());
    }
}

} // namespace
} // namespace hvi::solver
