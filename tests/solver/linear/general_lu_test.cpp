// Factors with pivots by size: against dense algebra, on random saddle points in any units.
#include "matrices.hpp"
#include "solver/linear/general_lu.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

/// [A, B^T; C, 0] with A positive definite: an elimination in this order meets no zero, in others
/// it does.
struct SaddlePoint {
  DenseMatrix dense;
  SparseMatrix sparse;
  Vector units, units_of_rows; ///< sizes of solutions, of K and of its transpose
  SaddlePoint(std::mt19937& random, int n, int m) : dense(DenseMatrix::Zero(n + m, n + m)) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0), exponent(-8.0, 8.0);
    const auto any = [&](int rows, int columns) {
      return DenseMatrix(DenseMatrix::NullaryExpr(rows, columns, [&] { return unit(random); }));
    };
    const DenseMatrix root = any(n, n);
    dense.topLeftCorner(n, n) = root * root.transpose() + DenseMatrix::Identity(n, n);
    dense.topRightCorner(n, m) = any(n, m);
    dense.bottomLeftCorner(m, n) = dense.topRightCorner(n, m).transpose() + 0.1 * any(m, n);
    const double column = std::pow(10.0, exponent(random)), row = std::pow(10.0, exponent(random));
    dense.rightCols(m) *= column;
    dense.bottomRows(m) *= row;
    sparse = dense.sparseView();
    units = units_of_rows = Vector::Ones(n + m);
    units.tail(m) /= column, units_of_rows.tail(m) /= row;
  }
};

TEST(GeneralLu, SolvesAndCondensesSaddlePointsInAnyUnits) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0.5, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    const int n = 6 + trial % 5, m = 1 + trial % 3;
    const SaddlePoint k(random, n, m);
    const std::vector<int> contact{0, 2};
    const auto factor = general_factor(k.sparse, contact);
    factor->factor(k.sparse);
    const Vector any = Vector::NullaryExpr(n + m, [&] { return unit(random); });
    const Vector wanted = any.cwiseProduct(k.units), other = any.cwiseProduct(k.units_of_rows);
    Vector x, y, r;
    solve(*factor, k.dense * wanted, x);
    EXPECT_LT(test::largest_error(x, wanted), 1e-9);
    solve(*factor, k.dense.transpose() * other, x, Columns::transposed);
    EXPECT_LT(test::largest_error(x, other), 1e-9);
    forward(*factor, k.dense * wanted, y, r);
    const Vector at_contact = wanted(contact);
    EXPECT_LT(test::largest_error(factor->schur() * at_contact, r), 1e-8);
    back(*factor, at_contact, y, x);
    EXPECT_LT(test::largest_error(x, wanted), 1e-8);
  }
}

/// A chain that a soft spring at its contact unknown holds: K^-1 is its rigid motion, and what one
/// of its springs does is lost there.
TEST(GeneralLu, KeepsStrainsBesideARigidMotion) {
  const int n = 20;
  DenseMatrix chain = DenseMatrix::Zero(n, n);
  chain(0, 0) = 1e-9;
  for (int i = 0; i + 1 < n; ++i) {
    chain(i, i) += 1.0, chain(i + 1, i + 1) += 1.0;
    chain(i, i + 1) -= 1.0, chain(i + 1, i) -= 1.0;
  }
  const SparseMatrix sparse = chain.sparseView();
  const std::vector<int> contact{0};
  const auto factor = general_factor(sparse, contact);
  factor->factor(sparse);
  EXPECT_NEAR(factor->schur()(0, 0), 1e-9, 1e-15);
  Vector b = Vector::Zero(n), y, r, x;
  b[5] = 1.0, b[6] = -1.0;
  forward(*factor, b, y, r);
  EXPECT_NEAR(r[0], 0.0, 1e-15);
  back(*factor, Vector::Constant(1, 3.0), y, x);
  for (int i = 0; i < n; ++i) EXPECT_NEAR(x[i], i < 6 ? 3.0 : 2.0, 1e-13);
}

TEST(GeneralLu, WhatIsSingularHasNoFactor) {
  std::mt19937 random(5);
  SaddlePoint k(random, 6, 2);
  k.dense.row(7) = 2.0 * k.dense.row(6);
  const auto factor = [](const DenseMatrix& dense, std::span<const int> contact) {
    const SparseMatrix sparse = dense.sparseView();
    general_factor(sparse, contact)->factor(sparse);
  };
  EXPECT_THROW(factor(k.dense, {}), NotFactorable);
  // The pressure is seen by the contact unknown alone: without it there is no way to condense.
  DenseMatrix between = DenseMatrix::Identity(3, 3);
  between(2, 2) = 0.0;
  between(0, 2) = between(2, 0) = 1.0;
  const std::vector<int> contact{0};
  EXPECT_THROW(factor(between, contact), NotFactorable);
  const std::vector<int> with_pressure{0, 2};
  EXPECT_NO_THROW(factor(between, with_pressure));
}

} // namespace
} // namespace hvi::solver
