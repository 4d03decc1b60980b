// Solves with a rounded copy of a factor against those with the factor itself.
#include "solver/linear/mixed/rounded_factor.hpp"
#include "tests/solver/linear/matrices.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>

namespace hvi::solver::test {
namespace {

constexpr auto full = FactorPrecision::full, fine = FactorPrecision::fine,
               single = FactorPrecision::single;

Vector random_vector(Eigen::Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  return Vector::NullaryExpr(n, [&] { return value(random); });
}

/// A matrix with its factor and the rounded copy.
struct Rounded {
  Rounded(const SparseMatrix& k, std::vector<int> contact) : factor(analyse(k, contact, true)) {
    factor->factor(k);
    EXPECT_TRUE(copy.take(*factor));
  }
  /// K^-1 b with two rounded solves.
  Vector solve(FactorPrecision precision, const Vector& b) {
    const EliminationOrder& order = factor->order();
    Vector y, x;
    order.gather(b, y);
    copy.forward(precision, y);
    const Vector c = factor->schur().llt().solve(Vector(y.tail(order.contacts())));
    y.tail(order.contacts()) = c;
    copy.back(precision, y);
    order.scatter(y, x);
    return x;
  }
  /// The backward solve of c after the forward solve of b.
  Vector back(FactorPrecision forward, FactorPrecision back, const Vector& b, const Vector& c) {
    const EliminationOrder& order = factor->order();
    Vector y, x;
    order.gather(b, y);
    if (forward == full)
      factor->forward(y, Columns::interior);
    else
      copy.forward(forward, y);
    y.tail(order.contacts()) = c;
    if (back != full) {
      copy.back(back, y);
    } else {
      if (forward != full) copy.complete(y);
      factor->back(y, Columns::interior);
    }
    order.scatter(y, x);
    return x;
  }
  std::unique_ptr<Factorisation> factor;
  RoundedFactor copy;
};

// A solve in reduced precision solves for a correction; two or three of them reach full accuracy.
TEST(RoundedFactor, ThreeCorrectionsAreFullAccuracy) {
  const auto check = [](const Problem& problem, FactorPrecision precision,
                        std::initializer_list<double> bounds) {
    Rounded rounded(problem.k, problem.contact);
    const Vector b = random_vector(problem.k.rows(), 11);
    Vector exact, x = Vector::Zero(problem.k.rows());
    hvi::solver::solve(*rounded.factor, b, exact);
    double last = exact.norm();
    for (const double bound : bounds) {
      x += rounded.solve(precision, b - problem.k * x);
      const double error = (x - exact).norm();
      EXPECT_LT(error, bound * exact.norm());
      EXPECT_LT(error, last);
      last = error;
    }
    x = rounded.solve(precision, b);
    EXPECT_GT((x - exact).norm(), 1e-14 * exact.norm()) << "not solved in reduced precision";
  };
  for (const Problem& problem : {slab(24), cube(7)}) {
    check(problem, single, {1e-4, 1e-8, 1e-12});
    check(problem, fine, {2e-11, 1e-13});
  }
}

// Forward rounded and back in full, as where little is left of the body's own gap and the contact
// unknowns move far: the error is that of a small part.
TEST(RoundedFactor, TheTwoSolvesMayHaveTwoPrecisions) {
  for (const Problem& problem : {slab(24), cube(7)}) {
    Rounded rounded(problem.k, problem.contact);
    const Vector b = 1e-6 * random_vector(problem.k.rows(), 4);
    const Vector c = random_vector(static_cast<int>(problem.contact.size()), 5);
    const Vector exact = rounded.back(full, full, b, c);
    const auto error_of = [&](FactorPrecision forward, FactorPrecision back) {
      return (rounded.back(forward, back, b, c) - exact).norm() / exact.norm();
    };
    const double rough = error_of(single, single), finer = error_of(fine, fine);
    EXPECT_LT(error_of(single, full), 1e-12);
    EXPECT_GT(rough, 1e3 * error_of(single, full));
    EXPECT_LT(finer, rough / 1e4); // sixteen bits more
    EXPECT_GT(finer, rough / 1e6);
    EXPECT_LT(error_of(single, fine), 2.0 * finer); // the solve back decides
    EXPECT_LT(error_of(fine, full), error_of(single, full) / 1e3);
  }
}

TEST(RoundedFactor, ServesInEverySystemOfUnits) {
  const Vector b = Vector::Ones(36);
  const SparseMatrix laplacian = grid_laplacian(6);
  for (const auto precision : {single, fine})
    for (const double unit : {1.0, 1e-200, 1e-90, 1e80, 1e200}) {
      Rounded rounded(SparseMatrix(unit * laplacian), {});
      Vector x = rounded.solve(precision, unit * b);
      EXPECT_LT((laplacian * x - b).norm(), 1e-5) << unit;
      for (int k = 0; k < 2; ++k) x += rounded.solve(precision, unit * (b - laplacian * x));
      EXPECT_LT((laplacian * x - b).norm(), 1e-13) << unit;
    }
}

TEST(RoundedFactor, IsThatOfTheLastValues) {
  const Problem problem = slab(12);
  Rounded rounded(problem.k, problem.contact);
  const Vector b = random_vector(problem.k.rows(), 3), x = rounded.solve(fine, b);
  const double bytes = rounded.copy.statistics().bytes;
  EXPECT_GT(bytes, 0.0);
  rounded.factor->factor(SparseMatrix(3.0 * problem.k));
  ASSERT_TRUE(rounded.copy.take(*rounded.factor));
  EXPECT_LT((3.0 * rounded.solve(fine, b) - x).norm(), 1e-9 * x.norm());
  EXPECT_EQ(rounded.copy.statistics().bytes, bytes);
  EXPECT_EQ(rounded.copy.statistics().triangular_solves, 4);
  rounded.copy.forget();
  EXPECT_EQ(rounded.copy.statistics().bytes, 0.0);
}

TEST(RoundedFactor, ThereIsNoneOfAnLuFactor) {
  const auto lu = analyse(grid_laplacian(6), {}, false);
  lu->factor(grid_laplacian(6));
  EXPECT_FALSE(RoundedFactor().take(*lu));
}

} // namespace
} // namespace hvi::solver::test
