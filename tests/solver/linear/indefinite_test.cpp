// L D L^T of matrices with several unknowns: against dense algebra, on random saddle points in any
// units, and where only pivots by size, or nothing, will do.
#include "matrices.hpp"
#include "solver/linear/indefinite.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

using Units = std::vector<std::uint8_t>;

/// Two unknowns, [A, c B^T; r B, -r c C] in units that make c and r anything: A positive definite,
/// C positive semidefinite or 0; unknowns in turn.
struct TwoUnknowns {
  DenseMatrix dense;
  Units of_unknown;
  Vector sizes, sizes_of_rows; ///< of solutions, of K and of its transpose

  TwoUnknowns(std::mt19937& random, int n, int m, bool stokes) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0), exponent(-8.0, 8.0);
    const auto any = [&](int rows, int columns) {
      return DenseMatrix(DenseMatrix::NullaryExpr(rows, columns, [&] { return unit(random); }));
    };
    const double column = std::pow(10.0, exponent(random)), row = -std::pow(10.0, exponent(random));
    const DenseMatrix root = any(n, n), b = any(m, n), c = any(m, m);
    DenseMatrix k = DenseMatrix::Zero(n + m, n + m);
    k.topLeftCorner(n, n) = root * root.transpose() + DenseMatrix::Identity(n, n);
    k.topRightCorner(n, m) = column * b.transpose();
    k.bottomLeftCorner(m, n) = row * b;
    if (!stokes) k.bottomRightCorner(m, m) = -row * column * (c * c.transpose());
    std::vector<int> order(static_cast<std::size_t>(n + m));
    for (int i = 0; i < n + m; ++i) order[static_cast<std::size_t>(i)] = i;
    std::shuffle(order.begin(), order.end(), random);
    dense = k(order, order);
    sizes = sizes_of_rows = Vector::Ones(n + m);
    for (int i = 0; i < n + m; ++i) {
      const bool second = order[static_cast<std::size_t>(i)] >= n;
      of_unknown.push_back(second ? 1 : 0);
      if (second) sizes[i] = 1.0 / column, sizes_of_rows[i] = 1.0 / std::abs(row);
    }
  }
};

void check(const DenseMatrix& dense, const Vector& sizes, const Vector& sizes_of_rows,
           const Units& of_unknown, const std::vector<int>& contact, const std::string& ordering) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.5, 1.0);
  const SparseMatrix sparse = dense.sparseView();
  auto factor = coupled_factor(sparse, contact, of_unknown);
  factor->factor(sparse);
  EXPECT_EQ(factor->statistics().ordering, ordering);
  for (int again = 0; again < 2; ++again) {
    const Vector any = Vector::NullaryExpr(dense.rows(), [&] { return unit(random); });
    const Vector wanted = any.cwiseProduct(sizes), other = any.cwiseProduct(sizes_of_rows);
    Vector x, y, r;
    solve(*factor, dense * wanted, x);
    EXPECT_LT(test::largest_error(x, wanted), 1e-8);
    solve(*factor, dense.transpose() * other, x, Columns::transposed);
    EXPECT_LT(test::largest_error(x, other), 1e-8);
    forward(*factor, dense * wanted, y, r);
    const Vector at_contact = wanted(contact);
    EXPECT_LT(test::largest_error(factor->schur() * at_contact, r), 1e-8);
    back(*factor, at_contact, y, x);
    EXPECT_LT(test::largest_error(x, wanted), 1e-8);
    auto next = factor->another();
    next->factor(sparse);
    factor = std::move(next);
  }
}

TEST(CoupledFactor, IsSymmetricUpToRowsInAnyUnits) {
  std::mt19937 random(12);
  for (int trial = 0; trial < 60; ++trial) {
    const TwoUnknowns k(random, 8 + trial % 5, 2 + trial % 3, trial % 2 == 0);
    check(k.dense, k.sizes, k.sizes_of_rows, k.of_unknown, {0, 3}, "CAMD");
  }
}

TEST(CoupledFactor, TakesPivotsBySizeWhereKIsNotSymmetric) {
  std::mt19937 random(13);
  TwoUnknowns k(random, 9, 2, true);
  k.dense(0, 3) += 0.5 * k.dense(0, 0);
  const SparseMatrix sparse = k.dense.sparseView();
  EXPECT_EQ(symmetrising_rows(sparse, k.of_unknown).size(), 0);
  check(k.dense, k.sizes, k.sizes_of_rows, k.of_unknown, {0, 3}, "AMD or COLAMD");
}

TEST(CoupledFactor, SeesThatUnknownsActTheOneWay) {
  DenseMatrix k = DenseMatrix::Identity(4, 4);
  k(0, 1) = k(1, 0) = 0.3;
  k(0, 2) = 0.5; // the second unknown acts on the first one, which does nothing to it
  const SparseMatrix sparse = k.sparseView();
  EXPECT_EQ(symmetrising_rows(sparse, Units{0, 0, 1, 1}).size(), 0);
  EXPECT_EQ(symmetrising_rows(sparse.transpose(), Units{0, 0, 1, 1}).size(), 0);
}

TEST(CoupledFactor, WhatIsSingularHasNoFactor) {
  const auto factor = [](const DenseMatrix& dense, const Units& of, std::vector<int> contact) {
    const SparseMatrix sparse = dense.sparseView();
    coupled_factor(sparse, contact, of)->factor(sparse);
  };
  std::mt19937 random(5);
  TwoUnknowns k(random, 8, 3, true); // two pressures act alike
  const auto& of = k.of_unknown;
  std::vector<int> pressures;
  for (int i = 0; i < 11; ++i)
    if (of[static_cast<std::size_t>(i)] == 1) pressures.push_back(i);
  k.dense.row(pressures[1]) = k.dense.row(pressures[0]);
  k.dense.col(pressures[1]) = k.dense.col(pressures[0]);
  EXPECT_THROW(factor(k.dense, of, {}), NotFactorable);
  // One of them among the contact unknowns: what they are condensed to is singular.
  EXPECT_THROW(factor(k.dense, of, {pressures[0]}), NotFactorable);
  // A pressure that only a contact unknown sees.
  DenseMatrix between = DenseMatrix::Identity(3, 3);
  between(2, 2) = 0.0;
  between(0, 2) = between(2, 0) = 1.0;
  EXPECT_THROW(factor(between, {0, 0, 1}, {0}), NotFactorable);
  factor(between, {0, 0, 1}, {0, 2});
}

} // namespace
} // namespace hvi::solver
