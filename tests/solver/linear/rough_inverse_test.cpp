// The inverse in single precision against dense linear algebra in double precision.
#include "matrices.hpp"
#include "solver/linear/rough_inverse.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hvi::solver::test {
namespace {

std::vector<float> lower_factor(const DenseMatrix& matrix) {
  const Eigen::MatrixXf factor = matrix.llt().matrixL().toDenseMatrix().cast<float>();
  return {factor.data(), factor.data() + factor.size()};
}

/// All sizes about the blocks of the recursion, and those at which spotri of some BLAS ends.
TEST(RoughInverse, IsTheInverse) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  for (const int n : {0, 1, 2, 7, 31, 32, 33, 63, 64, 65, 66, 97, 133, 235, 263, 300}) {
    const DenseMatrix root = DenseMatrix::NullaryExpr(n, n, [&] { return value(random); });
    const DenseMatrix matrix = root * root.transpose() + n * DenseMatrix::Identity(n, n);
    std::vector<float> work = lower_factor(matrix);
    ASSERT_TRUE(invert_from_factor(work, n)) << n;
    if (n == 0) continue;
    const DenseMatrix found = Eigen::Map<Eigen::MatrixXf>(work.data(), n, n)
                                  .cast<double>()
                                  .selfadjointView<Eigen::Lower>();
    EXPECT_LE((found * matrix - DenseMatrix::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-4) << n;
  }
}

TEST(RoughInverse, RefusesASingularFactor) {
  std::vector<float> factor = lower_factor(DenseMatrix::Identity(70, 70));
  factor[70 * 50 + 50] = 0.0F;
  EXPECT_FALSE(invert_from_factor(factor, 70));
}

} // namespace
} // namespace hvi::solver::test
