// The matrix of a step with its factor: what is made anew, what is taken over; one correction with
// it; and where the next step begins.
#include "solver/step/corrector.hpp"
#include "solver/step/warm_start.hpp"
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;

struct MatrixOfASlab : testing::Test {
  Plan plan = slab(4, 6);
  Discretisation d;
  std::unique_ptr<Formulation> formulation;
  std::mt19937_64 random{23};

  void SetUp() override {
    plan.options.proportional_path = false;
    for (const auto& mistake : discretise(plan, d)) throw mistake;
    formulation = formulate(plan, d);
  }
  const Operators& operators() const { return formulation->operators(); }
  const Contact& contact() const { return formulation->contact(); }
  Vector gamma(double factor) const { return Vector::Constant(operators().n_bases(), factor); }
  Vector any(Eigen::Index size) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    return Vector::NullaryExpr(size, [&] { return unit(random); });
  }
  /// |K x - b| / |b| of a solve with the factor.
  double error_of(const FactoredMatrix& matrix) {
    const Vector b = any(matrix.k().rows());
    Vector x;
    solve(*matrix.factorisation(), b, x);
    return (matrix.k() * x - b).norm() / b.norm();
  }
};

TEST_F(MatrixOfASlab, IsAnalysedOnceHoweverOftenItIsFactored) {
  FactoredMatrix first(operators(), contact()), other(operators(), contact(), &first);
  first.factor(gamma(1.0));
  const auto* factor = first.factorisation().get();
  other.factor(gamma(2.0));
  first.factor(gamma(3.0));
  EXPECT_EQ(first.factorisation().get(), factor);
  EXPECT_EQ(first.factorisation().statistics().analyses, 1);
  EXPECT_EQ(first.factorisation().statistics().factorisations, 2);
  EXPECT_EQ(other.factorisation().statistics().analyses, 0);
  EXPECT_LT(error_of(first), 1e-12);
  EXPECT_LT(error_of(other), 1e-12);
  const double one = condition(first, operators());
  EXPECT_NEAR(one, condition(other, operators()), 1e-6 * one);
}

TEST_F(MatrixOfASlab, LeavesAFactorOfOtherRunsAsItIs) {
  SharedWork work;
  Operators shared = operators();
  shared.shared = &work;
  FactoredMatrix matrix(shared, contact());
  matrix.factor(gamma(1.0));
  ASSERT_TRUE(matrix.factorisation().is_shared());
  const SharedFactor before = matrix.factorisation();
  matrix.factor(gamma(2.0));
  EXPECT_FALSE(matrix.factorisation().is_shared());
  EXPECT_LT(error_of(matrix), 1e-12);
  const Vector b = any(matrix.k().rows());
  Vector x, half;
  solve(*before, b, x);
  solve(*matrix.factorisation(), b, half);
  EXPECT_LT((2.0 * half - x).norm(), 1e-10 * x.norm());
}

TEST_F(MatrixOfASlab, SharesFactorsOfOnePrecisionOnly) {
  SharedWork work;
  Operators shared = operators();
  shared.shared = &work;
  const auto factored = [&](FactorEntries entries) {
    FactoredMatrix matrix(shared, contact());
    matrix.set_entries(entries);
    matrix.factor(gamma(1.0));
    EXPECT_EQ(matrix.in_singles(), entries == FactorEntries::singles);
  };
  factored(FactorEntries::doubles);
  factored(FactorEntries::singles);
  EXPECT_EQ(work.spared().factors, 0);
  factored(FactorEntries::singles);
  factored(FactorEntries::doubles);
  EXPECT_EQ(work.spared().factors, 2);
}

TEST_F(MatrixOfASlab, ItsHalfIsThatOfTheLastCoefficients) {
  std::vector<SymmetricBlocks> bases;
  for (const auto& base : operators().bases) bases.emplace_back(base, operators().mirrored);
  FactoredMatrix matrix(operators(), contact());
  const double without = (matrix.factor(gamma(1.0)), matrix.bytes());
  EXPECT_TRUE(matrix.half({}).empty());
  for (const double factor : {1.0, 3.0}) {
    matrix.factor(gamma(factor));
    const Vector x = any(matrix.k().cols());
    Vector y = Vector::Zero(x.size());
    matrix.half(bases).add_product(x, y);
    EXPECT_LT((y - matrix.k() * x).norm(), 1e-13 * y.norm());
  }
  EXPECT_GT(matrix.bytes(), without);
}

/// K d + G^T W xi = b after one correction, from zero and from any state.
TEST_F(MatrixOfASlab, OneCorrectionSolvesTheEquation) {
  StepMatrix matrix(operators(), contact(), {});
  matrix.factor(gamma(1.0));
  formulation->contact().problem.offset.setZero(contact().n_rows());
  Corrector corrector(contact(), false);
  CorrectionSolves solves(1e-10);
  const Vector b = any(matrix.k().rows());
  InequalityState state;
  state.xi = Vector::Zero(contact().n_rows());
  state.c = Vector::Zero(static_cast<Eigen::Index>(contact().unknowns.size()));
  const auto left = [&](const Vector& of) {
    return (b - matrix.k() * of - contact().force * state.xi).norm() / b.norm();
  };
  Vector increment;
  ASSERT_TRUE(corrector.start(matrix, b, state, increment).converged);
  EXPECT_LT(left(increment), 1e-11);
  EXPECT_GT(state.xi.norm(), 0.0);
  Vector from = increment + 0.1 * any(increment.size());
  const auto made =
      corrector.correct(matrix, b - matrix.k() * from, nullptr, false, solves, state, from);
  ASSERT_TRUE(made.report.converged);
  EXPECT_GT(made.moved, 0.0);
  EXPECT_LT(left(from), 1e-11);
  EXPECT_LT((from - increment).norm(), 1e-9 * increment.norm());
}

/// Three steps with one matrix make an extrapolation, which is exact for parabolas.
TEST_F(MatrixOfASlab, TheFourthStepBeginsAtAnExtrapolation) {
  plan.problem.histories.clear();
  Evolution evolution(plan, formulation->initial(), formulation->imposed());
  evolution.start();
  StepMatrix matrix(operators(), contact(), {}), other(operators(), contact(), {});
  matrix.factor(gamma(1.0));
  other.factor(gamma(2.0));
  WarmStart warm_start(evolution, contact());
  InequalityState laws;
  const Vector shape = any(matrix.k().rows()), xi = any(contact().n_rows());
  const auto d_of = [&](int n) -> Vector { return (1.0 + 0.5 * n * n) * shape; };
  StepEquation equation;
  Trial trial;
  for (int n = 1; n <= 4; ++n) {
    equation.n = n;
    equation.rhs = matrix.k() * d_of(n);
    trial.d.setZero(shape.size());
    EXPECT_EQ(warm_start.predict(matrix, equation, trial, laws), n == 4) << n;
    if (n == 4) break;
    trial.d = d_of(n), trial.kd = matrix.k() * trial.d;
    warm_start.note(n, matrix, trial, n * xi);
  }
  EXPECT_LT((trial.d - d_of(4)).norm(), 1e-13 * d_of(4).norm());
  EXPECT_LT(trial.gap.norm(), 1e-12 * equation.rhs.norm());
  EXPECT_LT((laws.xi_guess - 4.0 * xi).norm(), 1e-13 * xi.norm());
  for (std::size_t i = 0; i < contact().unknowns.size(); ++i)
    EXPECT_EQ(laws.c_guess[static_cast<Eigen::Index>(i)], trial.d[contact().unknowns[i]]);
  warm_start.drop_guess(laws);
  EXPECT_EQ(laws.xi_guess.size() + laws.c_guess.size(), 0);
  EXPECT_FALSE(warm_start.predict(other, equation, trial, laws)) << "of another matrix";
  warm_start.find_change(4, matrix.gamma(), matrix, equation, trial.d);
  EXPECT_TRUE(equation.exact());
  warm_start.find_change(4, other.gamma(), matrix, equation, trial.d);
  EXPECT_EQ(equation.change, matrix.gamma());
  EXPECT_LT((equation.expected.head(shape.size()) - d_of(4)).norm(), 1e-13 * d_of(4).norm());
  warm_start.clear();
  EXPECT_FALSE(warm_start.ready());
}

} // namespace
} // namespace hvi::solver
