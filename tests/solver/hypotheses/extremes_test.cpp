// Generalised eigenvalues against the dense solver and closed forms.
#include "solver/hypotheses/extremes.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

/// Stiffness of a chain of n springs clamped at one end, with the given springs.
SparseMatrix chain(const std::vector<double>& springs) {
  const auto n = static_cast<int>(springs.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, springs[i]);
    if (i == 0) continue;
    entries.emplace_back(i - 1, i - 1, springs[i]);
    entries.emplace_back(i, i - 1, -springs[i]);
    entries.emplace_back(i - 1, i, -springs[i]);
  }
  SparseMatrix out(n, n);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

/// Analytic: a chain against the chain with unit springs has the springs as eigenvalues.
TEST(Extremes, AChainHasItsSprings) {
  for (const int n : {20, 400}) {
    std::vector<double> springs(n), ones(n, 1.0);
    for (int i = 0; i < n; ++i) springs[i] = 2.0 + std::sin(0.37 * i);
    springs[n / 3] = 0.25, springs[n / 2] = 7.5;
    const GramForm gram(chain(ones));
    const SparseMatrix k = chain(springs);
    ASSERT_TRUE(gram.least(k) && gram.largest(k) && gram.norm(k));
    EXPECT_NEAR(*gram.least(k), 0.25, 1e-7) << n;
    EXPECT_NEAR(*gram.largest(k), 7.5, 1e-7) << n;
    if (n > 20) {
      EXPECT_NEAR(*gram.norm(k), 7.5, 1e-6);
    }
  }
}

/// Analytic: pairs of unknowns [a c; c d] of two units, whose least eigenvalue is negative and up
/// to 1e-12 times the largest one; at 0, the least one is that of a body that nothing holds.
TEST(Extremes, NegativeOnesOfAnySize) {
  const int n = 300;
  for (const double c : {0.0, 1e-3, 0.3, 20.0, 1e5}) {
    SparseMatrix k(2 * n, 2 * n), g(2 * n, 2 * n);
    g.setIdentity();
    double least = 0.0;
    for (int i = 0; i < n; ++i) {
      const double a = 1e6 * (1.0 + 0.5 * std::sin(0.37 * i)), d = i == n / 2 ? 0.0 : 1.0 + i;
      k.insert(2 * i, 2 * i) = a;
      k.insert(2 * i, 2 * i + 1) = k.insert(2 * i + 1, 2 * i) = c;
      k.insert(2 * i + 1, 2 * i + 1) = d;
      // The smaller root of l^2 - (a + d) l + a d - c^2, without cancellation.
      const double root = 0.5 * ((a + d) + std::hypot(a - d, 2.0 * c));
      least = std::min(least, (a * d - c * c) / root);
    }
    const GramForm gram(g);
    ASSERT_TRUE(gram.least(k)) << c;
    EXPECT_NEAR(*gram.least(k), least, 1e-7 * std::abs(least) + 1e-12 * 1.5e6) << c;
  }
}

/// Analytic: pairs [0 c; c 0], a form between two unknowns alone, whose diagonal is zero: -c.
TEST(Extremes, AFormBetweenUnknownsAlone) {
  const int n = 300;
  SparseMatrix k(2 * n, 2 * n), g(2 * n, 2 * n);
  g.setIdentity();
  for (int i = 0; i < n; ++i)
    k.insert(2 * i, 2 * i + 1) = k.insert(2 * i + 1, 2 * i) = i == n / 3 ? 3.0 : 1.0 / (1.0 + i);
  const GramForm gram(g);
  ASSERT_TRUE(gram.least(k));
  EXPECT_NEAR(*gram.least(k), -3.0, 1e-6);
}

/// Analytic: the end of a chain of n unit springs moves by n for a unit force: ||M||^2 = n.
TEST(Extremes, TheTraceOfAChain) {
  const int n = 300;
  const GramForm gram(chain(std::vector<double>(n, 1.0)));
  SparseMatrix trace(n, n);
  trace.insert(n - 1, n - 1) = 1.0;
  EXPECT_NEAR(*gram.largest(trace), n, 1e-9 * n);
}

/// Independent: Eigen's dense solver on a random unsymmetric form.
TEST(Extremes, AgreeWithTheDenseSolver) {
  const int n = 160;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i)
    for (int j : {i, (i * 7 + 3) % n, (i * 11 + 5) % n}) entries.emplace_back(i, j, normal(random));
  SparseMatrix k(n, n);
  k.setFromTriplets(entries.begin(), entries.end());
  std::vector<double> springs(n);
  for (double& s : springs) s = 1.0 + std::abs(normal(random));
  const GramForm gram(chain(springs));
  const DenseMatrix dense = DenseMatrix(k), g = DenseMatrix(gram.matrix());
  const Vector spectrum = Eigen::GeneralizedSelfAdjointEigenSolver<DenseMatrix>(
                              DenseMatrix(0.5 * (dense + dense.transpose())), g)
                              .eigenvalues();
  EXPECT_NEAR(*gram.least(k), spectrum[0], 1e-6 * std::abs(spectrum[0]));
  EXPECT_NEAR(*gram.largest(k), spectrum[n - 1], 1e-6 * spectrum[n - 1]);
  const DenseMatrix l = g.llt().matrixL();
  const DenseMatrix scaled = l.triangularView<Eigen::Lower>().solve(
      l.triangularView<Eigen::Lower>().solve(dense).transpose());
  EXPECT_NEAR(*gram.norm(k), scaled.jacobiSvd().singularValues()[0],
              1e-6 * scaled.jacobiSvd().singularValues()[0]);
}

} // namespace
} // namespace hvi::solver
