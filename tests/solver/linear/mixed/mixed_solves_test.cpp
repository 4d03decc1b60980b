// When the solves of corrections are rough, and that they are the factor's own else.
#include "solver/linear/mixed/mixed_solves.hpp"
#include "tests/solver/linear/matrices.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace hvi::solver::test {
namespace {

constexpr double tolerance = 1e-10;

class MixedSolvesTest : public testing::Test {
protected:
  MixedSolvesTest() : factor_(analyse(problem_.k, problem_.contact, true)) {
    factor_->factor(problem_.k);
  }

  /// Corrects once, and moves so far; returns the interior's error against the factor's own solves.
  double error_of(CorrectionSolves& solves, double moved) {
    const Vector b = Vector::LinSpaced(problem_.k.rows(), -1.0, 1.0);
    Vector y, exact;
    factor_->order().gather(b, y);
    exact = y;
    factor_->forward(exact, Columns::interior);
    factor_->back(exact, Columns::interior);
    solves.forward(*factor_, y);
    solves.back(*factor_, moved, y);
    return (y - exact).norm() / exact.norm();
  }
  /// A step of this matrix that began at a guess; the first correction's error.
  double step(CorrectionSolves& solves, double moved) {
    solves.begin(problem_.k, true);
    const double out = error_of(solves, moved);
    solves.judge(moved, 1e-14, true);
    EXPECT_EQ(error_of(solves, moved), 0.0) << "a second correction";
    solves.accept(problem_.k, *factor_, true, 100);
    return out;
  }

  Problem problem_ = slab(12);
  std::unique_ptr<Factorisation> factor_;
};

TEST_F(MixedSolvesTest, AreTheFactorsOwnInGeneral) {
  CorrectionSolves own(tolerance);
  EXPECT_EQ(own.begin(problem_.k, true), tolerance);
  EXPECT_EQ(step(own, 1e-6), 0.0);
  EXPECT_EQ(own.statistics().triangular_solves, 0);
}

// One step shows how far the unknowns move: from the next one on solves are as rough as may be.
TEST_F(MixedSolvesTest, AreRoughWhereUnknownsMoveLittle) {
  const auto solves = mixed_solves(tolerance, true);
  EXPECT_EQ(solves->begin(problem_.k, true), tolerance);
  EXPECT_EQ(step(*solves, 1e-6), 0.0);
  EXPECT_LT(solves->begin(problem_.k, true), tolerance) << "a part of it for rounding";
  EXPECT_EQ(step(*solves, 1e-6), 0.0) << "`begin` forgot how far the last step moved";
  const double rough = step(*solves, 1e-6);
  step(*solves, 5e-2);
  const double finer = step(*solves, 5e-2); // forward with 48 bits, too, as the last one moved far
  EXPECT_GT(rough, 1e-12);
  EXPECT_LT(rough, 1e-5);
  EXPECT_GT(finer, 1e-16);
  EXPECT_LT(finer, rough / 1e3);
  EXPECT_GT(solves->statistics().bytes, 0.0);
  EXPECT_EQ(solves->statistics().triangular_solves, 6);
}

TEST_F(MixedSolvesTest, AreTheFactorsOwnFromZeroAndOfOtherMatrices) {
  const auto solves = mixed_solves(tolerance, true);
  const SparseMatrix other = problem_.k;
  for (int k = 0; k < 2; ++k) step(*solves, 1e-6);
  solves->begin(problem_.k, false);
  EXPECT_EQ(error_of(*solves, 1e-6), 0.0);
  solves->judge(1e-6, 1e-14, true);
  solves->accept(problem_.k, *factor_, true, 100);
  step(*solves, 1e-6);
  EXPECT_EQ(solves->begin(other, true), tolerance);
  EXPECT_EQ(error_of(*solves, 1e-6), 0.0);
}

TEST_F(MixedSolvesTest, AreNotWorthTheCopyForAFewSteps) {
  const auto solves = mixed_solves(tolerance, true);
  solves->begin(problem_.k, true);
  solves->judge(1e-6, 1e-14, true);
  solves->accept(problem_.k, *factor_, true, 23);
  EXPECT_EQ(solves->statistics().bytes, 0.0);
  solves->accept(problem_.k, *factor_, false, 100);
  EXPECT_EQ(solves->statistics().bytes, 0.0);
  solves->accept(problem_.k, *factor_, true, 24);
  EXPECT_GT(solves->statistics().bytes, 0.0);
}

TEST_F(MixedSolvesTest, StopForGood) {
  const auto solves = mixed_solves(tolerance, true);
  for (int k = 0; k < 2; ++k) step(*solves, 1e-6);
  EXPECT_GT(step(*solves, 1e-6), 0.0);
  solves->stop();
  EXPECT_EQ(solves->statistics().bytes, 0.0);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(step(*solves, 1e-6), 0.0);
}

TEST_F(MixedSolvesTest, AreSavedWithTheirMatrix) {
  const SparseMatrix other = problem_.k;
  const SparseMatrix* const all[] = {&other, &problem_.k};
  const auto solves = mixed_solves(tolerance, true), again = mixed_solves(tolerance, true);
  for (int k = 0; k < 2; ++k) step(*solves, 1e-6);
  std::stringstream saved;
  solves->save(saved, all);
  again->restore(saved, all);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(step(*again, 1e-6), step(*solves, 1e-6));
  EXPECT_GT(step(*again, 1e-6), 0.0);
}

} // namespace
} // namespace hvi::solver::test
