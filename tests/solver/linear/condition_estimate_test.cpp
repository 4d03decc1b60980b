// The condition number from a few solves, against dense inverses; sums in extended precision.
#include "solver/linear/condition_estimate.hpp"
#include "solver/linear/double_double.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <random>

namespace hvi::solver::test {
namespace {

double exact_condition(const SparseMatrix& k) {
  const DenseMatrix dense(k);
  const auto norm = [](const DenseMatrix& a) { return a.cwiseAbs().colwise().sum().maxCoeff(); };
  return norm(dense) * norm(dense.inverse());
}

/// A chain of springs whose stiffnesses spread over `decades`, coercive; with a skew part it is not
/// symmetric.
SparseMatrix chain(int n, double decades, double skew, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    const double stiffness = std::pow(10.0, decades * (unit(random) - 0.5));
    entries.emplace_back(i, i, stiffness);
    if (i + 1 == n) break;
    entries.emplace_back(i + 1, i + 1, stiffness);
    entries.emplace_back(i, i + 1, -stiffness * (1.0 + skew));
    entries.emplace_back(i + 1, i, -stiffness * (1.0 - skew));
  }
  SparseMatrix k(n, n);
  k.setFromTriplets(entries.begin(), entries.end());
  return k;
}

TEST(ConditionEstimate, IsALowerBoundNearTheTruth) {
  std::mt19937 random(7);
  int near = 0, all = 0;
  for (int scene = 0; scene < 200; ++scene) {
    const int n = 2 + static_cast<int>(random() % 60);
    const bool symmetric = scene % 2 == 0;
    const SparseMatrix k = chain(n, 0.05 * scene, symmetric ? 0.0 : 0.4, random);
    const auto factor = analyse(k, std::vector{0}, symmetric);
    factor->factor(k);
    const double estimate = estimate_condition(k, *factor), exact = exact_condition(k);
    // The exact one has the rounding of a dense inverse: unit roundoff times itself.
    EXPECT_LE(estimate, exact * (1 + 1e-6 + 1e-15 * exact)) << scene;
    EXPECT_GE(estimate, exact / 10) << scene;
    near += estimate >= exact / 3, ++all;
  }
  EXPECT_GE(near, 0.98 * all);
}

TEST(ConditionEstimate, SolvesWithTheTranspose) {
  std::mt19937 random(3);
  const SparseMatrix k = chain(40, 2, 0.7, random);
  const auto factor = analyse(k, std::vector{5, 17}, false);
  factor->factor(k);
  const Vector b = Vector::Random(40);
  Vector x;
  solve(*factor, b, x, Columns::transposed);
  EXPECT_LT((k.transpose() * x - b).norm(), 1e-12 * b.norm());
}

TEST(DoubleDouble, KeepsWhatCancels) {
  // sum_i a_i b_i of integers with 50 digits' range: exact in 128 bits.
  std::mt19937_64 random(1);
  for (int scene = 0; scene < 100; ++scene) {
    DoubleDouble sum;
    __extension__ typedef __int128 Wide;
    Wide exact = 0;
    double plain = 0.0;
    for (int i = 0; i < 40; ++i) {
      const auto a = static_cast<std::int64_t>(random() >> 14) - (std::int64_t{1} << 49);
      const auto b = static_cast<std::int64_t>(random() >> 40) - (1 << 23);
      sum.add_product(static_cast<double>(a), static_cast<double>(b));
      plain += static_cast<double>(a) * static_cast<double>(b);
      exact += static_cast<Wide>(a) * b;
    }
    EXPECT_EQ(sum.value(), static_cast<double>(exact)) << scene << ", plain: " << plain;
  }
}

} // namespace
} // namespace hvi::solver::test
