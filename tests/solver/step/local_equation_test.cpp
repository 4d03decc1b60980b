// States at one point against all choices of held and free ones.
#include "solver/linear/sparse.hpp"
#include "solver/step/local_equation.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

/// z = P(b + c (A z + d)), I - c A with a dominant positive diagonal: one solution.
struct Linear {
  DenseMatrix a;
  Vector b, d, low, high;
  double c = 1.0;
};

Linear random_linear(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const int n = 2 + static_cast<int>(random() % 3);
  Linear out{DenseMatrix::Zero(n, n), Vector::Random(n), Vector::Random(n), Vector(n), Vector(n)};
  out.c = std::pow(10.0, 2.0 * uniform(random));
  for (int i = 0; i < n; ++i) {
    const double fast = std::pow(10.0, 4.0 * uniform(random));
    double sum = 0.0;
    for (int j = 0; j < n; ++j)
      if (j != i) sum += std::abs(out.a(i, j) = fast * uniform(random));
    out.a(i, i) = -sum * (1.01 + std::abs(uniform(random)));
    out.d[i] = fast * uniform(random);
    out.b[i] = uniform(random);
    out.low[i] = -std::abs(uniform(random)), out.high[i] = std::abs(uniform(random));
    if (random() % 2 == 0) out.high[i] = HUGE_VAL;
  }
  return out;
}

/// Tries each state at its lower end, free, and at its upper end.
Vector by_enumeration(const Linear& e) {
  const auto n = static_cast<int>(e.b.size());
  Vector best = Vector::Zero(n);
  double least = HUGE_VAL;
  for (int choice = 0; choice < std::lround(std::pow(3, n)); ++choice) {
    DenseMatrix m = DenseMatrix::Identity(n, n) - e.c * e.a;
    Vector right = e.b + e.c * e.d;
    for (int i = 0, rest = choice; i < n; ++i, rest /= 3) {
      if (rest % 3 == 1) continue;
      m.row(i).setZero();
      m(i, i) = 1.0, right[i] = rest % 3 == 0 ? e.low[i] : e.high[i];
    }
    if (!right.allFinite()) continue;
    const Vector z = m.partialPivLu().solve(right);
    const Vector moved = e.b + e.c * (e.a * z + e.d);
    const Vector scale = (Vector::Ones(n) - e.c * e.a.diagonal()).cwiseInverse();
    const Vector wanted = (z - scale.cwiseProduct(z - moved)).cwiseMax(e.low).cwiseMin(e.high);
    const double left = (z - wanted).lpNorm<Eigen::Infinity>();
    if (left < least) least = left, best = z;
  }
  return best;
}

TEST(LocalEquation, AgreesWithAllChoicesOfHeldStates) {
  std::mt19937 random(5);
  for (int k = 0; k < 2000; ++k) {
    const Linear e = random_linear(random);
    const auto n = static_cast<int>(e.b.size());
    LocalEquation equation;
    equation.known.assign(e.b.begin(), e.b.end());
    equation.low.assign(e.low.begin(), e.low.end());
    equation.high.assign(e.high.begin(), e.high.end());
    equation.factor = e.c;
    equation.rates = [&](std::span<const double> z, std::span<double> g) {
      Eigen::Map<Vector>(g.data(), n) = e.a * Eigen::Map<const Vector>(z.data(), n) + e.d;
    };
    equation.derivatives = [&](std::span<const double>, std::span<double> by) {
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) by[static_cast<std::size_t>(i * n + j)] = e.a(i, j);
    };
    std::vector<double> z(static_cast<std::size_t>(n), 0.0);
    ASSERT_TRUE(solve_local(equation, z)) << k;
    const Vector expected = by_enumeration(e);
    const double size = 1e-3 + expected.lpNorm<Eigen::Infinity>();
    for (int i = 0; i < n; ++i)
      EXPECT_NEAR(z[static_cast<std::size_t>(i)], expected[i], 1e-10 * size) << k;
  }
}

} // namespace
} // namespace hvi::solver
