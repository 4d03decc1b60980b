// Scaling of saddle points: units of a pressure must not leave the stiffness beside it as rounding.
#include "solver/linear/scaling.hpp"

#include <gtest/gtest.h>

#include <random>

namespace hvi::solver {
namespace {

/// [G C^T; C 0] of random numbers, the last `multipliers` rows in units of their own.
DenseMatrix saddle_point(int n, int multipliers, double unit) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  DenseMatrix out = DenseMatrix::NullaryExpr(n, n, [&] { return number(random); });
  out = DenseMatrix(out * out.transpose()) + DenseMatrix::Identity(n, n);
  const int first = n - multipliers;
  out.block(first, first, multipliers, multipliers).setZero();
  out.bottomRows(multipliers) *= unit;
  out.rightCols(multipliers) *= unit;
  return out;
}

Scaling scaling_of_dense(const DenseMatrix& m) {
  return scaling_of(m.rows(), [&m](const auto& f) {
    for (Eigen::Index i = 0; i < m.rows(); ++i)
      for (Eigen::Index j = 0; j < m.cols(); ++j) f(i, j, m(i, j));
  });
}

TEST(Scaling, KeepsWhatHasADiagonalWhateverTheUnitOfTheRest) {
  const int n = 12, multipliers = 4;
  for (const double unit : {1e-20, 1e-6, 1.0, 1e6, 1e20}) {
    const DenseMatrix m = saddle_point(n, multipliers, unit);
    const auto [rows, columns] = scaling_of_dense(m);
    const DenseMatrix scaled = rows.asDiagonal() * m * columns.asDiagonal();
    EXPECT_LE(scaled.cwiseAbs().maxCoeff(), 1.0 + 1e-12) << unit;
    EXPECT_GT(scaled.cwiseAbs().rowwise().maxCoeff().minCoeff(), 0.5) << unit;
    EXPECT_GT(scaled.cwiseAbs().colwise().maxCoeff().minCoeff(), 0.5) << unit;
    EXPECT_GT(scaled.diagonal().head(n - multipliers).cwiseAbs().minCoeff(), 0.1) << unit;
  }
}

TEST(Scaling, LeavesNoEntryOverOneWhereCouplingsAreLarge) {
  DenseMatrix m = DenseMatrix::Identity(3, 3);
  m(0, 1) = 1e30, m(1, 2) = -1e-40, m(2, 0) = 1e12;
  const auto [rows, columns] = scaling_of_dense(m);
  const DenseMatrix scaled = rows.asDiagonal() * m * columns.asDiagonal();
  EXPECT_LE(scaled.cwiseAbs().maxCoeff(), 10.0);
  EXPECT_GT(scaled.cwiseAbs().rowwise().maxCoeff().minCoeff(), 0.1);
}

} // namespace
} // namespace hvi::solver
