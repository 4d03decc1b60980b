// The dense operator of the reduced inequality against Eigen's dense algebra: products, sums of
// absolute values, and factors that leave out what is held.
#include "solver/inequality/inequality.hpp"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

namespace hvi::solver {
namespace {

Vector random_vector(int n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Vector v(n);
  for (double& x : v) x = uniform(random);
  return v;
}

/// A body's stiffness between points on a line: definite, with signs of both kinds.
DenseMatrix stiffness(int n, double unit) {
  DenseMatrix s(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      s(i, j) = i == j             ? 4.0
                : (i + j) % 3 == 0 ? 0.5 / (i - j) / (i - j)
                                   : -1.0 / (i - j) / (i - j);
  return unit * s;
}

SparseMatrix diagonal(const Vector& d) {
  SparseMatrix h(d.size(), d.size());
  for (int i = 0; i < d.size(); ++i) h.insert(i, i) = d[i];
  h.makeCompressed();
  return h;
}

TEST(DenseOperator, MultipliesAndSumsSizes) {
  for (const int n : {1, 7, 50, 131}) {
    const Vector c = random_vector(n, 1);
    for (const bool symmetric : {true, false}) {
      DenseMatrix s = stiffness(n, 3.0);
      if (!symmetric) s.triangularView<Eigen::StrictlyUpper>() *= 0.3;
      const auto op = dense_operator(s, symmetric);
      Vector out;
      op->apply(c, out);
      EXPECT_LT((out - s * c).norm(), 1e-13 * (s * c).norm());
      op->apply_magnitude(c, out);
      const Vector expected = s.cwiseAbs() * c.cwiseAbs();
      EXPECT_LT((out - expected).norm(), 1e-14 * expected.norm());
    }
  }
}

// Sizes below and above the one from which factors are rounded; a third of the unknowns is held.
TEST(DenseOperator, SolvesWithAndWithoutHeldUnknowns) {
  for (const int n : {90, 450})
    for (const double unit : {1.0, 1e-100, 1e100}) {
      const DenseMatrix s = stiffness(n, unit);
      Vector d = unit * (random_vector(n, 2).array() + 1.0).matrix();
      std::vector<int> held;
      for (int i = 0; i < n; i += 3) held.push_back(i), d[i] = 1e13 * s(i, i);
      const DenseMatrix sum = s + DenseMatrix(d.asDiagonal());
      const Vector b = random_vector(n, 3);
      const Vector exact = sum.ldlt().solve(b);
      const auto op = dense_operator(s, true);
      for (const auto& left_out : {std::vector<int>{}, held}) {
        ASSERT_TRUE(op->factor(diagonal(d), left_out));
        Vector x;
        op->solve_rough(b, x);
        EXPECT_LT((x - exact).norm(), 1e-5 * exact.norm());
        DenseMatrix columns(n, 2);
        columns << b, 2.0 * b;
        op->solve_rough(columns);
        EXPECT_LT((columns.col(0) - exact).norm(), 1e-5 * exact.norm());
        EXPECT_LT((columns.col(1) - 2.0 * exact).norm(), 2e-5 * exact.norm());
        op->solve(b, x);
        EXPECT_LT((x - exact).norm(), 1e-11 * exact.norm());
        // Held unknowns move by their force over their stiffness, to a few digits of their own.
        for (const int i : held)
          EXPECT_NEAR(x[i] * d[i], exact[i] * d[i], 1e-2 * b.lpNorm<Eigen::Infinity>());
      }
    }
}

// Nothing is left for a factor, and LAPACK would complain about a matrix without rows, between the
// results.
TEST(DenseOperator, HoldsAllUnknowns) {
  const int n = 450;
  const DenseMatrix s = stiffness(n, 1.0);
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  const Vector d = 1e13 * s.diagonal();
  const auto op = dense_operator(s, true);
  testing::internal::CaptureStdout();
  ASSERT_TRUE(op->factor(diagonal(d), all));
  const Vector b = random_vector(n, 3);
  Vector x;
  op->solve(b, x);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_LT((d.cwiseProduct(x) - b).norm(), 1e-9 * b.norm());
}

TEST(DenseOperator, RefusesWhatIsNotDefinite) {
  for (const int n : {90, 450}) {
    const auto op = dense_operator(stiffness(n, 1.0), true);
    Vector d = Vector::Zero(n);
    d[n - 1] = -8.0;
    EXPECT_FALSE(op->factor(diagonal(d), {}));
    d[n - 2] = 1e14;
    EXPECT_FALSE(op->factor(diagonal(d), std::vector<int>{n - 2}));
    d[n - 1] = 0.0;
    EXPECT_TRUE(op->factor(diagonal(d), std::vector<int>{n - 2}));
  }
}

} // namespace
} // namespace hvi::solver
