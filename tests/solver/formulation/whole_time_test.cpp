// From solutions with the matrix of a step to those with the matrix of the whole time, against
// dense algebra.
#include "solver/formulation/whole_time.hpp"
#include "tests/solver/time/plans.hpp"

#include <Eigen/Dense>

#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;

struct WholeBody {
  Plan plan = slab(3, 40);
  Discretisation d;
  StateLayout layout;
  Operators operators;
  Contact none;

  WholeBody() {
    plan.problem.law_terms.clear(), plan.problem.laws.clear();
    plan.problem.histories.clear(), plan.problem.forms.pop_back();
    plan.problem.forms[0] =
        elastic(2, body, field_of_u(1), {40, 1}); // of quite another shape than B
    plan.report = {};
    for (const auto& mistake : discretise(plan, d)) throw mistake;
    layout = make_layout(d.space, d.dofs);
    operators = assemble_operators(plan.problem, d, layout, 1);
    none = make_contact(plan.problem, d, layout);
  }
  Vector coefficients(double length) const { return whole_coefficients(operators, length, {}); }
  DenseMatrix matrix(double length) const {
    return DenseMatrix(combine(operators, coefficients(length)));
  }
};

/// The coefficients are those of u and of u' over the length, and of each memory what it is given.
TEST(WholeTime, CoefficientsAreThoseOfOneStep) {
  const WholeBody body;
  const DenseMatrix half = body.matrix(0.5), two = body.matrix(2.0);
  EXPECT_LT((half - two).norm(), (half + two).norm());
  // K(length) = B + A / length: three lengths lie on one line in 1 / length.
  const DenseMatrix one = body.matrix(1.0);
  EXPECT_LT((half - one - 2.0 * (one - two)).norm(), 1e-12 * one.norm());
  Plan plan = slab(3, 4);
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  const auto operators = assemble_operators(plan.problem, d, make_layout(d.space, d.dofs), 1);
  const double w[] = {1.0};
  // The memory's tensor is -B: with the weight 1 the two cancel, and A / length is left.
  const DenseMatrix viscous = combine(operators, whole_coefficients(operators, 4.0, w));
  const DenseMatrix twice = combine(operators, whole_coefficients(operators, 2.0, w));
  EXPECT_LT((twice - 2.0 * viscous).norm(), 1e-12 * viscous.norm());
}

TEST(WholeTime, FindsTheSolutionOfOneLongStep) {
  WholeBody body;
  const double step = 1.0 / 40, whole = 1.0;
  InequalityOptions options;
  StepMatrix matrix(body.operators, body.none, options);
  matrix.factor(body.coefficients(step));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  InequalityState at;
  for (int scene = 0; scene < 10; ++scene) {
    const Vector force =
        Vector::NullaryExpr(body.layout.n_unknowns, [&](Eigen::Index) { return unit(random); });
    std::vector<Vector> x, xi;
    ASSERT_TRUE(respond(matrix, std::span<const Vector>(&force, 1), at, x, xi));
    const DenseMatrix of_step = body.matrix(step), of_all = body.matrix(whole);
    EXPECT_LT((of_step * x[0] - force).norm(), 1e-10 * force.norm());
    WholeTime one(body.operators, matrix, at, body.layout.n_state,
                  body.coefficients(step) - body.coefficients(whole));
    const Vector expected = of_all.ldlt().solve(force), before = x[0];
    Vector found = before, multipliers;
    ASSERT_TRUE(one.relax(force, 42, 40.0, found, multipliers));
    EXPECT_LT((found - expected).norm(), 0.2 * expected.norm()); // an estimate
    EXPECT_GT((before - expected).norm(), 0.3 * expected.norm());
    // What is stopped after too few vectors is left as it was.
    WholeTime again(body.operators, matrix, at, body.layout.n_state,
                    body.coefficients(step) - body.coefficients(whole));
    found = before;
    EXPECT_FALSE(again.relax(force, 1, 40.0, found, multipliers));
    EXPECT_EQ(found, before);
  }
}

/// The number of vectors is what costs little beside the run: none for large contact, thirty at
/// most.
TEST(WholeTime, TakesAsManyVectorsAsAreCheap) {
  EXPECT_EQ(vectors_for_whole_time(100, 10, 10), 60);
  EXPECT_EQ(vectors_for_whole_time(1000, 0, 0), 30);
  EXPECT_EQ(vectors_for_whole_time(3000, 0, 0), 10);
  EXPECT_EQ(vectors_for_whole_time(1000000, 0, 10), 0);
  EXPECT_EQ(vectors_for_whole_time(1000000, 0, 800), 8); // a hundredth of the steps
  EXPECT_EQ(vectors_for_whole_time(3000, 300, 0), 0);
}

} // namespace
} // namespace hvi::solver
