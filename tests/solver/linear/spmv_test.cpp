// Fused products and the componentwise backward error, against dense algebra.
#include "matrices.hpp"
#include "solver/linear/bandwidth.hpp"
#include "solver/linear/spmv.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hvi::solver::test {
namespace {

TEST(FusedProducts, AgreeWithDenseSums) {
  const SparseMatrix pattern = random_definite(60, 0.1, 1);
  std::vector<SparseMatrix> matrices;
  std::vector<Vector> vectors;
  for (int t = 0; t < 6; ++t) {
    matrices.push_back(with_skew_part(pattern, 1.0, static_cast<unsigned>(t)));
    vectors.push_back(Vector::LinSpaced(60, -t - 1.0, 2.0 * t));
    EXPECT_TRUE(same_pattern(matrices.front(), matrices.back()));
  }
  for (int count = 0; count <= 6; ++count) {
    std::vector<Product> terms;
    Vector expected = Vector::Zero(60);
    for (int t = 0; t < count; ++t) {
      terms.push_back({&matrices[t], &vectors[t], 0.5 + t});
      expected += (0.5 + t) * (DenseMatrix(matrices[t]) * vectors[t]);
    }
    Vector y = Vector::Constant(60, 99.0);
    multiply(terms, y);
    EXPECT_LT((y - expected).norm(), 1e-13 * (1.0 + expected.norm()));
  }
}

TEST(FusedProducts, TellPatternsApart) {
  const SparseMatrix a = grid_laplacian(4), b = grid_laplacian(5);
  SparseMatrix c = a;
  c.coeffRef(0, 15) = 1.0;
  EXPECT_FALSE(same_pattern(a, b));
  EXPECT_FALSE(same_pattern(a, c)); // not compressed
  c.makeCompressed();
  EXPECT_FALSE(same_pattern(a, c));
  EXPECT_TRUE(same_pattern(a, grid_laplacian(4, 3.0)));
}

TEST(BackwardErrorOf, FindsTheWorstRowAndTheResidual) {
  const SparseMatrix k = random_definite(40, 0.2, 2);
  Vector x = Vector::LinSpaced(40, -1.0, 1.0);
  Vector b = k * x;
  EXPECT_LT(backward_error(k, x, b).error, 1e-15);
  b[17] += 1e-6;
  Vector r;
  const BackwardError found = backward_error(k, x, b, &r);
  const Vector scale =
      DenseMatrix(k).cwiseAbs() * x.cwiseAbs() + b.cwiseAbs(); // the definition, densely
  EXPECT_EQ(found.row, 17);
  EXPECT_NEAR(found.error, 1e-6 / scale[17], 1e-14);
  EXPECT_LT((r - (b - k * x)).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(BackwardErrorOf, IsZeroForZeroAndKeepsNan) {
  const SparseMatrix k = grid_laplacian(3);
  const Vector zero = Vector::Zero(9);
  EXPECT_EQ(backward_error(k, zero, zero).error, 0.0);
  EXPECT_EQ(backward_error(k, zero, Vector::Ones(9)).error, 1.0);
  Vector bad = Vector::Ones(9);
  bad[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(backward_error(k, bad, zero).error));
}

TEST(ReadBandwidth, IsPlausible) {
  const double speed = read_bandwidth(8);
  EXPECT_GT(speed, 0.0);
  EXPECT_TRUE(std::isfinite(speed));
}

} // namespace
} // namespace hvi::solver::test
