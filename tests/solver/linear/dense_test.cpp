// Dense and sparse decompositions by LAPACK and UMFPACK, against Eigen's and against what they
// mean, on random matrices of any size and scale.
#include "solver/linear/dense.hpp"
#include "solver/linear/sparse_lu.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

constexpr int scenes = 300;

class Dense : public ::testing::Test {
protected:
  int size(int least, int most) { return std::uniform_int_distribution(least, most)(source_); }
  double number() { return std::uniform_real_distribution(-1.0, 1.0)(source_); }
  /// Of any unit.
  double unit() { return std::pow(10.0, 12.0 * number()); }
  DenseMatrix matrix(int rows, int columns) {
    DenseMatrix out(rows, columns);
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) out(i, j) = number();
    return out;
  }
  DenseMatrix symmetric(int n) {
    const DenseMatrix a = matrix(n, n);
    return unit() * (a + a.transpose());
  }
  DenseMatrix positive(int n) {
    const DenseMatrix a = matrix(n, n);
    return unit() * (a * a.transpose() + 0.1 * DenseMatrix::Identity(n, n));
  }

private:
  std::mt19937_64 source_{20261129};
};

double largest(const DenseMatrix& a) { return a.size() == 0 ? 0.0 : a.cwiseAbs().maxCoeff(); }

void expect_near(const DenseMatrix& a, const DenseMatrix& b, double tolerance) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  EXPECT_LE(largest(a - b), tolerance * largest(b)) << a.rows() << " by " << a.cols();
}

TEST(DenseMatrices, ArePositiveDefiniteInAnyUnits) {
  DenseMatrix a(2, 2);
  a << 2e12, 1.0, 1.0, 1e-12;
  EXPECT_TRUE(is_positive_definite(a, 1e-11));
  a(0, 1) += 1e-10;
  EXPECT_FALSE(is_positive_definite(a, 1e-11)); // not symmetric
  a << 2e12, 2.0, 2.0, 1e-12;
  EXPECT_FALSE(is_positive_definite(a, 1e-11)); // not definite
}

TEST_F(Dense, SpectraAreEigens) {
  for (int i = 0; i < scenes; ++i) {
    const DenseMatrix a = symmetric(size(1, 40));
    const Eigen::SelfAdjointEigenSolver<DenseMatrix> eigen(a);
    expect_near(symmetric_eigenvalues(a), eigen.eigenvalues(), 1e-12);
    const auto [values, vectors] = symmetric_spectrum(a);
    expect_near(values, eigen.eigenvalues(), 1e-12);
    expect_near(a * vectors, vectors * values.asDiagonal(), 1e-12);
    expect_near(vectors.transpose() * vectors, DenseMatrix::Identity(a.rows(), a.rows()), 1e-12);
  }
}

TEST_F(Dense, GeneralisedEigenvaluesAreEigens) {
  for (int i = 0; i < scenes; ++i) {
    const int n = size(1, 30);
    const DenseMatrix a = symmetric(n), g = positive(n);
    const Eigen::GeneralizedSelfAdjointEigenSolver<DenseMatrix> eigen(a, g);
    expect_near(generalised_eigenvalues(a, g), eigen.eigenvalues(), 1e-10);
  }
}

/// Products and sums of the eigenvalues are determinants and traces, of the powers, too.
TEST_F(Dense, EigenvaluesHaveTheTracesOfPowers) {
  for (int i = 0; i < scenes; ++i) {
    const int n = size(1, 20);
    const DenseMatrix a = matrix(n, n);
    const Eigen::VectorXcd values = eigenvalues(a);
    DenseMatrix power = a;
    for (int k = 1; k <= 4; ++k, power = power * a)
      EXPECT_LE(std::abs(values.array().pow(k).sum() - power.trace()), 1e-11 * n * std::pow(n, k));
  }
}

TEST_F(Dense, SingularVectorsSpanTheColumns) {
  for (int i = 0; i < scenes; ++i) {
    const DenseMatrix a = unit() * matrix(size(1, 30), size(1, 30));
    const auto [values, vectors] = left_singular(a);
    expect_near(values, Eigen::JacobiSVD<DenseMatrix>(a).singularValues(), 1e-12);
    expect_near(vectors.transpose() * vectors, DenseMatrix::Identity(values.size(), values.size()),
                1e-12);
    const DenseMatrix squares = vectors * values.cwiseAbs2().asDiagonal() * vectors.transpose();
    expect_near(squares, a * a.transpose(), 1e-12);
  }
}

TEST_F(Dense, CholeskySolves) {
  for (int i = 0; i < scenes; ++i) {
    const int n = size(1, 40);
    const DenseMatrix g = positive(n), b = matrix(n, size(1, 5));
    const DenseCholesky factor(g);
    ASSERT_TRUE(factor.positive());
    const DenseMatrix l = factor.lower();
    expect_near(l * l.transpose(), g, 1e-13);
    expect_near(l * factor.solve_lower(b), b, 1e-10);
    expect_near(g * factor.solve(b), b, 1e-9);
    expect_near(factor.solve(Vector(b.col(0))), factor.solve(b).col(0), 1e-9);
    DenseMatrix indefinite = g;
    const int at = size(0, n - 1);
    indefinite(at, at) = -1e-3 * g(at, at);
    EXPECT_FALSE(DenseCholesky(indefinite).positive());
    EXPECT_TRUE(solve_positive(indefinite, b).array().isNaN().all());
  }
}

TEST_F(Dense, LuSolvesAndKnowsItsCondition) {
  for (int i = 0; i < scenes; ++i) {
    const int n = size(1, 40);
    const DenseMatrix a = unit() * matrix(n, n), b = matrix(n, size(1, 5));
    const DenseLu factor(a);
    const Eigen::PartialPivLU<DenseMatrix> eigen(a);
    const double condition = factor.inverse_condition();
    EXPECT_NEAR(condition / eigen.rcond(), 1.0, 1.0); // both are estimates
    const double tolerance = 1e-14 * n / condition;
    expect_near(factor.solve(b), eigen.solve(b), tolerance);
    expect_near(factor.solve(Vector(b.col(0)), true), eigen.transpose().solve(b.col(0)), tolerance);
    expect_near(solve_square(a, b), factor.solve(b), 0.0);
    expect_near(factor.pivots(), eigen.matrixLU().diagonal().cwiseAbs(), 1e-9);
  }
}

/// With columns that depend on others, more rows than columns or fewer.
TEST_F(Dense, LeastSquaresAreTheShortest) {
  for (int i = 0; i < scenes; ++i) {
    const int rows = size(1, 25), columns = size(1, 25), rank = size(1, std::min(rows, columns));
    const DenseMatrix a = unit() * matrix(rows, rank) * matrix(rank, columns);
    const DenseMatrix b = matrix(rows, size(1, 3));
    Eigen::JacobiSVD<DenseMatrix> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Vector values = svd.singularValues();
    if (values[rank - 1] < 1e-6 * values[0]) continue; // which columns depend is open
    svd.setThreshold(1e-10);
    const DenseMatrix expected = svd.solve(b);
    expect_near(least_squares(a, b), expected, 1e-6);
    expect_near(least_squares(a, b, 1e-10), expected, 1e-6);
  }
}

/// Two columns 1e-11 apart count as two, unless what is that small is asked to count as nothing.
TEST_F(Dense, WhatIsSmallCountsUnlessItIsRounding) {
  for (int i = 0; i < scenes; ++i) {
    const Eigen::HouseholderQR<DenseMatrix> random(matrix(6, 6));
    const DenseMatrix q = random.householderQ();
    DenseMatrix a(6, 2);
    a << q.col(0), q.col(0) + 1e-11 * q.col(1);
    const Vector b = -1e-11 * q.col(1), expected = Eigen::Vector2d(1.0, -1.0);
    expect_near(least_squares(a, b), expected, 1e-3);
    EXPECT_LE(largest(least_squares(a, b, 1e-6)), 1e-7);
  }
}

TEST_F(Dense, QrSolves) {
  for (int i = 0; i < scenes; ++i) {
    const int columns = size(1, 15), rows = size(columns, 40);
    const DenseMatrix a = unit() * matrix(rows, columns);
    const Vector b = matrix(rows, 1);
    const auto [x, r] = solve_by_qr(a, b);
    const Eigen::HouseholderQR<DenseMatrix> eigen(a);
    expect_near(x, eigen.solve(b), 1e-8);
    expect_near(r.transpose() * r, a.transpose() * a, 1e-12);
    EXPECT_EQ(largest(r.triangularView<Eigen::StrictlyLower>()), 0.0);
  }
}

TEST_F(Dense, SparseLuSolvesAndKnowsTheSign) {
  SparseLu lu;
  for (int i = 0; i < scenes; ++i) {
    const int n = size(1, 30);
    DenseMatrix a = matrix(n, n);
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        if (j != k && number() > -0.5) a(k, j) = 0.0;
    const int sign = a.fullPivLu().determinant() > 0.0 ? 1 : -1;
    a = unit() * a;
    const Eigen::FullPivLU<DenseMatrix> eigen(a);
    if (eigen.rcond() < 1e-10) continue;
    ASSERT_TRUE(lu.factor(a.sparseView()));
    EXPECT_EQ(lu.determinant_sign(), sign);
    const Vector b = matrix(n, 1);
    expect_near(lu.solve(b), eigen.solve(b), 1e-5);
    const DenseMatrix many = matrix(n, 4);
    expect_near(DenseMatrix(lu.solve(SparseMatrix(many.sparseView()))), eigen.solve(many), 1e-5);
    a.row(size(0, n - 1)).setZero();
    EXPECT_FALSE(lu.factor(a.sparseView()));
    EXPECT_EQ(lu.determinant_sign(), 0);
  }
}

TEST_F(Dense, NothingIsNoMistake) {
  const DenseMatrix none(0, 0);
  EXPECT_EQ(symmetric_eigenvalues(none).size(), 0);
  EXPECT_EQ(generalised_eigenvalues(none, none).size(), 0);
  EXPECT_EQ(eigenvalues(none).size(), 0);
  EXPECT_EQ(left_singular(DenseMatrix(3, 0)).values.size(), 0);
  EXPECT_TRUE(DenseCholesky(none).positive());
  EXPECT_EQ(DenseCholesky(none).solve(Vector(0)).size(), 0);
  EXPECT_EQ(solve_square(none, DenseMatrix(0, 2)).cols(), 2);
  EXPECT_EQ(least_squares(DenseMatrix(3, 0), DenseMatrix::Ones(3, 2)).cols(), 2);
  EXPECT_EQ(largest(least_squares(DenseMatrix(0, 3), DenseMatrix(0, 1))), 0.0);
  SparseLu lu;
  EXPECT_TRUE(lu.factor(SparseMatrix(0, 0)));
}

TEST_F(Dense, WhatIsNotFiniteHasNoAnswer) {
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    DenseMatrix a = symmetric(5);
    a(3, 1) = a(1, 3) = bad;
    const DenseMatrix one = DenseMatrix::Identity(5, 5);
    EXPECT_TRUE(symmetric_eigenvalues(a).array().isNaN().all());
    EXPECT_TRUE(symmetric_spectrum(a).values.array().isNaN().all());
    EXPECT_TRUE(generalised_eigenvalues(a, one).array().isNaN().all());
    EXPECT_TRUE(generalised_eigenvalues(one, a).array().isNaN().all());
    EXPECT_TRUE(eigenvalues(a).real().array().isNaN().all());
    EXPECT_TRUE(left_singular(a).values.array().isNaN().all());
    EXPECT_TRUE(least_squares(a, one).array().isNaN().all());
    EXPECT_FALSE(solve_square(a, one).allFinite());
    SparseLu lu;
    EXPECT_FALSE(lu.factor(a.sparseView()));
  }
  EXPECT_FALSE(solve_square(DenseMatrix::Zero(3, 3), DenseMatrix::Ones(3, 1)).allFinite());
  EXPECT_TRUE(generalised_eigenvalues(symmetric(4), -positive(4)).array().isNaN().all());
}

} // namespace
} // namespace hvi::solver
