// The equation of a step against its terms, written out.
#include "solver/step/refinement.hpp"
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// The first step of a slab on all unknowns: A, B and E have matrices of their own.
struct FirstStep : testing::Test {
  Plan plan = slab(4, 6);
  Discretisation d;
  std::unique_ptr<Formulation> formulation;
  std::optional<Evolution> evolution;
  std::optional<Balance> balance;
  StepEquation equation;
  std::mt19937_64 random{1905};

  void SetUp() override {
    plan.options.proportional_path = false;
    for (const auto& mistake : discretise(plan, d)) throw mistake;
    formulation = formulate(plan, d);
    evolution.emplace(plan, any(formulation->layout().n_state), formulation->imposed());
    evolution->start();
    ASSERT_FALSE(evolution->begin_step(1));
    balance.emplace(plan, d, *formulation, *evolution);
    equation.n = 1;
    balance->known_state(1, equation.known);
    equation.change = Vector::Zero(operators().n_bases());
    balance->find_right_hand_side(equation);
  }
  const Operators& operators() const { return formulation->operators(); }
  Vector any(Eigen::Index size) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    return Vector::NullaryExpr(size, [&] { return unit(random); });
  }
  /// rhs_n with a part of the matrix moved to it.
  void move_change() {
    equation.change = any(operators().n_bases());
    equation.expected = any(formulation->layout().n_state);
    balance->find_right_hand_side(equation);
  }
};

TEST_F(FirstStep, TheRightHandSideIsTheLoadLessWhatIsKnown) {
  Vector expected;
  balance->load.find(1, expected);
  const Vector& u0 = evolution->u();
  const double w0 = evolution->memory().w0(0);
  for (int b = 0; b < operators().n_bases(); ++b) {
    const auto weight = operators().weights.col(b);
    expected -= operators().bases[b] *
                (weight[field_of_u(0)] * u0 +
                 weight[field_of_memory(0)] * (w0 * u0 + evolution->memory().known(0)));
  }
  EXPECT_LT((equation.rhs - expected).norm(), 1e-13 * expected.norm());
}

TEST_F(FirstStep, AChangeOfTheMatrixGoesOverAndComesBack) {
  const Vector before = equation.rhs;
  for (const bool by_one : {false, true}) {
    move_change();
    if (by_one) {
      equation.change.setOnes();
      balance->find_right_hand_side(equation);
    }
    EXPECT_GT((equation.rhs - before).norm(), 1e-3 * before.norm());
    EXPECT_FALSE(equation.exact());
    take_back_change(operators(), equation);
    EXPECT_LT((equation.rhs - before).norm(), 1e-13 * before.norm()) << by_one;
    EXPECT_TRUE(equation.exact());
  }
}

TEST_F(FirstStep, TheResidualIsThatOfTheChangedMatrix) {
  const Vector plain = equation.rhs;
  StepMatrix matrix(operators(), formulation->contact(), {});
  const Vector gamma = balance->coefficients(1);
  const Vector xi = Vector::Zero(formulation->contact().n_rows());
  const auto n = plain.size();
  Trial trial{any(n), Vector::Zero(n), Vector::Zero(n), {}, {}};
  matrix.factor(gamma);
  for (const bool changed : {false, true}) {
    if (changed) move_change();
    balance->residual(equation, matrix, xi, trial);
    const Vector k_d = combine(operators(), gamma + equation.change) * trial.d;
    EXPECT_LT((trial.gap - (plain - k_d)).norm(), 1e-12 * k_d.norm()) << changed;
    EXPECT_LT((trial.kd - matrix.k() * trial.d).norm(), 1e-12 * k_d.norm()) << changed;
  }
}

/// Beside 1e-15 of the terms of the equation's sums, by the tolerance, and of K times the largest
/// values yet; for a tolerance of rounding beside nothing.
TEST_F(FirstStep, ErrorsAreMeasuredBesideTheRoundingOfTerms) {
  StepMatrix matrix(operators(), formulation->contact(), {});
  matrix.factor(balance->coefficients(1));
  const auto n = equation.rhs.size();
  const Vector xi = Vector::Zero(formulation->contact().n_rows());
  Trial trial{any(n), Vector::Zero(n), Vector::Zero(n), {}, {}};
  const DenseMatrix size = DenseMatrix(matrix.k()).cwiseAbs();
  Vector load, terms, gap(n), scale(n);
  balance->load.find(1, load);
  const Vector& u0 = evolution->u();
  terms = load.cwiseAbs();
  for (int b = 0; b < operators().n_bases(); ++b) {
    const auto weight = operators().weights.col(b);
    const Vector known = weight[field_of_u(0)] * u0 +
                         weight[field_of_memory(0)] *
                             (evolution->memory().w0(0) * u0 + evolution->memory().known(0));
    terms += DenseMatrix(operators().bases[b]).cwiseAbs() * known.cwiseAbs();
  }
  terms += size * Vector::Constant(n, u0.head(n).lpNorm<Eigen::Infinity>());
  gap_and_scale(matrix.k(), trial.d, equation.rhs, gap, scale);
  for (const double tolerance : {1e-8, 1e-15, 1e-12, 3e-14}) {
    Vector beside = scale;
    if (tolerance >= 1e-13) beside += 1e-15 / tolerance * terms;
    const double expected =
        equilibrium_error(matrix.k(), trial.d, gap, beside, formulation->contact().reactions(), xi);
    EXPECT_NEAR(balance->error_beside_rounding(equation, matrix, xi, trial, tolerance), expected,
                1e-12 * expected)
        << tolerance;
  }
}

TEST_F(FirstStep, MatricesTakeAValueAndAColumnPerEntry) {
  double entries = 0.0;
  for (const auto& base : operators().bases) entries += static_cast<double>(base.nonZeros());
  EXPECT_EQ(bytes_of(operators(), {}), 12.0 * entries);
}

TEST_F(FirstStep, ResidualsInExtendedPrecisionAreTheSame) {
  StepMatrix matrix(operators(), formulation->contact(), {});
  matrix.factor(balance->coefficients(1));
  const auto n = equation.rhs.size();
  Trial trial{any(n), Vector::Zero(n), Vector::Zero(n), {}, {}};
  Vector gap = Vector::Zero(n);
  const Vector xi = Vector::Zero(formulation->contact().n_rows());
  const double error = balance->residual(equation, matrix, xi, trial).error;
  PreciseEquation extended(*formulation, *evolution, *balance, equation);
  const double precise = extended.gap(matrix, trial.d, xi, gap);
  EXPECT_LT((gap - trial.gap).norm(), 1e-12 * gap.norm());
  EXPECT_NEAR(precise, error, 0.5 * error); // each by a scale of its own
}

} // namespace
} // namespace hvi::solver
